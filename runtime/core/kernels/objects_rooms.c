/* Evidence of rooms, added where a view reaches. */
#include "objects.h"
#include <math.h>

/* Adding 0 elsewhere changes nothing, and is done four cells at a time. */
static void add_where(const Grid *into, const Grid *mask, float value)
{
    for (Py_ssize_t row = 0; row < into->rows; row++) {
        float *restrict sums = GRID_ROW(*into, float, row);
        const uint8_t *restrict held = GRID_ROW(*mask, uint8_t, row);
        for (Py_ssize_t col = 0; col < into->cols; col++)
            sums[col] += held[col] ? value : 0.0f;
    }
}

PyObject *kernel_add_where(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    Grid into, mask;
    (void)module;
    if (count != 3)
        return PyErr_Format(PyExc_TypeError, "add_where takes 3 arguments, not %zd", count);
    const double value = PyFloat_AsDouble(args[2]);
    if (PyErr_Occurred() || grid_open(&into, args[0], 'f', 1, "into") < 0)
        return NULL;
    if (grid_open(&mask, args[1], 0, 0, "mask") < 0) {
        grid_close(&into);
        return NULL;
    }
    const int fits = into.rows == mask.rows && into.cols == mask.cols;
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        add_where(&into, &mask, (float)value);
        Py_END_ALLOW_THREADS
    }
    grid_close(&mask);
    grid_close(&into);
    if (!fits)
        return PyErr_Format(PyExc_ValueError, "add_where: into and mask are not of one shape");
    Py_RETURN_NONE;
}

/* An outline's points, as seen from its first, no farther from that than so; and their ends: left,
 * below, right, above. */
static void shorten(const Grid *outline, double reach_m, double *to, double *ends)
{
    const double *apex = GRID_ROW(*outline, double, 0);
    ends[0] = ends[1] = INFINITY;
    ends[2] = ends[3] = -INFINITY;
    for (Py_ssize_t n = 0; n < outline->rows; n++, to += 2) {
        const double *xy = GRID_ROW(*outline, double, n), dx = xy[0] - apex[0], dy = xy[1] - apex[1];
        const double share = reach_m / fmax(hypot(dx, dy), 1e-6);
        to[0] = apex[0] + dx * (share < 1.0 ? share : 1.0);
        to[1] = apex[1] + dy * (share < 1.0 ? share : 1.0);
        for (int k = 0; k < 2; k++) {
            ends[k] = to[k] < ends[k] ? to[k] : ends[k];
            ends[k + 2] = to[k] > ends[k + 2] ? to[k] : ends[k + 2];
        }
    }
}

PyObject *kernel_shortened(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    Grid outline;
    double ends[4];
    (void)module;
    if (count != 2)
        return PyErr_Format(PyExc_TypeError, "shortened takes 2 arguments, not %zd", count);
    const double reach_m = PyFloat_AsDouble(args[1]);
    if (PyErr_Occurred() || cells_open(&outline, args[0], "outline") < 0)
        return NULL;
    PyObject *bytes = PyBytes_FromStringAndSize(NULL, outline.rows * 2 * (Py_ssize_t)sizeof(double));
    if (bytes) {
        double *to = (double *)(void *)PyBytes_AsString(bytes);
        Py_BEGIN_ALLOW_THREADS
        shorten(&outline, reach_m, to, ends);
        Py_END_ALLOW_THREADS
    }
    grid_close(&outline);
    return bytes ? Py_BuildValue("(Ndddd)", bytes, ends[0], ends[1], ends[2], ends[3]) : NULL;
}
