/* What kernels are given, and how they tell what is wrong with it. */
#include "arguments.h"

const char NO_MEMORY[] = "out of memory";
const char TOO_MANY_CELLS[] = "more cells than can be numbered";

static const char *kind_of(const Py_buffer *view)
{
    const char *format = view->format ? view->format : "B";
    return *format == '@' || *format == '=' || *format == '<' ? format + 1 : format;
}

static int is_of(char kind, char found, Py_ssize_t bytes)
{
    if (kind == BYTES_OR_FLOATS)
        return bytes == 1 || found == 'f';
    return kind == BYTES ? bytes == 1 : found == kind;
}

int grid_open(Grid *grid, PyObject *array, GridSpec spec)
{
    const int flags = PyBUF_STRIDES | PyBUF_FORMAT | (spec.writable ? PyBUF_WRITABLE : 0);
    if (PyObject_GetBuffer(array, &grid->view, flags) < 0)
        return -1;
    const Py_buffer *view = &grid->view;
    const char *found = kind_of(view);
    if (!is_of(spec.kind, *found, view->itemsize)) {
        PyErr_Format(PyExc_TypeError, "%s: items of kind '%s' are not what is asked for",
                     spec.name, found);
    } else if (view->ndim != 2) {
        PyErr_Format(PyExc_ValueError, "%s: %d dimensions, not 2", spec.name, view->ndim);
    } else if (view->shape[1] > 1 && view->strides[1] != view->itemsize) {
        PyErr_Format(PyExc_ValueError, "%s: its rows are not contiguous", spec.name);
    } else if (view->shape[0] > LONGEST_SIDE || view->shape[1] > LONGEST_SIDE) {
        PyErr_Format(PyExc_ValueError, "%s: (%zd, %zd) is too large", spec.name, view->shape[0],
                     view->shape[1]);
    } else {
        grid->at = view->buf;
        grid->rows = view->shape[0];
        grid->cols = view->shape[1];
        grid->stride = view->strides[0];
        return 0;
    }
    PyBuffer_Release(&grid->view);
    return -1;
}

void grid_close(Grid *grid) { PyBuffer_Release(&grid->view); }

int grids_open(Grid *grids, PyObject *const *args, const GridSpec *specs, int count)
{
    for (int n = 0; n < count; n++) {
        if (grid_open(&grids[n], args[n], specs[n]) < 0) {
            grids_close(grids, n);
            return -1;
        }
    }
    return 0;
}

void grids_close(Grid *grids, int count)
{
    while (count-- > 0)
        grid_close(&grids[count]);
}

int grids_alike(const Grid *grids, const GridSpec *specs, int count)
{
    for (int n = 1; n < count; n++) {
        if (grids[n].rows != grids[0].rows || grids[n].cols != grids[0].cols) {
            PyErr_Format(PyExc_ValueError, "%s: (%zd, %zd) is not the shape of %s, (%zd, %zd)",
                         specs[n].name, grids[n].rows, grids[n].cols, specs[0].name,
                         grids[0].rows, grids[0].cols);
            return -1;
        }
    }
    return 0;
}

int points_open(Grid *grid, PyObject *array, const char *name)
{
    if (grid_open(grid, array, (GridSpec){'d', 0, name}) < 0)
        return -1;
    if (grid->rows > 0 && grid->cols == 2)
        return 0;
    PyErr_Format(PyExc_ValueError, "%s: (%zd, %zd), not (N, 2), N at least 1", name, grid->rows,
                 grid->cols);
    grid_close(grid);
    return -1;
}

int numbers_of(double *numbers, PyObject *const *args, int count)
{
    for (int n = 0; n < count; n++) {
        numbers[n] = PyFloat_AsDouble(args[n]);
        if (numbers[n] == -1.0 && PyErr_Occurred())
            return -1;
    }
    return 0;
}

int wholes_of(Py_ssize_t *wholes, PyObject *const *args, int count)
{
    for (int n = 0; n < count; n++) {
        wholes[n] = PyNumber_AsSsize_t(args[n], PyExc_OverflowError);
        if (wholes[n] == -1 && PyErr_Occurred())
            return -1;
    }
    return 0;
}

int numbers_in(double *numbers, Py_ssize_t count, PyObject *tuple, const char *name)
{
    if (PyTuple_Check(tuple) && PyTuple_Size(tuple) == count) {
        Py_ssize_t n = 0;
        for (; n < count; n++) {
            PyObject *number = PyTuple_GetItem(tuple, n);
            if (numbers_of(numbers + n, &number, 1) < 0)
                break;
        }
        if (n == count)
            return 0;
        if (!PyErr_ExceptionMatches(PyExc_TypeError))
            return -1;
    }
    PyErr_Format(PyExc_TypeError, "%s: not a tuple of %zd numbers", name, count);
    return -1;
}

int count_is(const char *kernel, Py_ssize_t count, Py_ssize_t wanted)
{
    if (count == wanted)
        return 0;
    PyErr_Format(PyExc_TypeError, "%s takes %zd arguments, not %zd", kernel, wanted, count);
    return -1;
}

PyObject *failed(const char *kernel, const char *problem)
{
    if (problem == NO_MEMORY)
        return PyErr_NoMemory();
    return PyErr_Format(PyExc_ValueError, "%s: %s", kernel, problem);
}
