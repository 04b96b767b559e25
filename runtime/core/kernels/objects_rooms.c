/* Evidence of rooms, added where a view reaches. */
#include "objects.h"

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
