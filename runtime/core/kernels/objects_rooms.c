/* Evidence of rooms, added where a view reaches. */
#include "arguments.h"
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

PyObject *kernel_add_where(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'f', 1, "into"}, {BYTES, 0, "mask"}};
    Grid grids[2];
    double value;
    if (count_is("add_where", count, 3) < 0 || numbers_of(&value, args + 2, 1) < 0 ||
        grids_open(grids, args, specs, 2) < 0)
        return NULL;
    const int alike = grids_alike(grids, specs, 2);
    if (alike == 0) {
        Py_BEGIN_ALLOW_THREADS
        add_where(&grids[0], &grids[1], (float)value);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 2);
    if (alike < 0)
        return NULL;
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
        const double *xy = GRID_ROW(*outline, double, n);
        const double dx = xy[0] - apex[0], dy = xy[1] - apex[1];
        const double share = reach_m / fmax(hypot(dx, dy), 1e-6);
        to[0] = apex[0] + dx * (share < 1.0 ? share : 1.0);
        to[1] = apex[1] + dy * (share < 1.0 ? share : 1.0);
        for (int k = 0; k < 2; k++) {
            ends[k] = to[k] < ends[k] ? to[k] : ends[k];
            ends[k + 2] = to[k] > ends[k + 2] ? to[k] : ends[k + 2];
        }
    }
}

PyObject *kernel_shortened(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid outline;
    double ends[4], reach_m;
    if (count_is("shortened", count, 2) < 0 || numbers_of(&reach_m, args + 1, 1) < 0 ||
        points_open(&outline, args[0], "outline") < 0)
        return NULL;
    const Py_ssize_t size = outline.rows * 2 * (Py_ssize_t)sizeof(double);
    PyObject *bytes = PyBytes_FromStringAndSize(NULL, size);
    if (bytes) {
        double *to = (double *)(void *)PyBytes_AsString(bytes);
        Py_BEGIN_ALLOW_THREADS
        shorten(&outline, reach_m, to, ends);
        Py_END_ALLOW_THREADS
    }
    grid_close(&outline);
    return bytes ? Py_BuildValue("(Ndddd)", bytes, ends[0], ends[1], ends[2], ends[3]) : NULL;
}
