/* How alike two embeddings are. */
#include "arguments.h"
#include <math.h>
#include <string.h>

static int vector_open(Py_buffer *view, PyObject *array, const char *name)
{
    if (PyObject_GetBuffer(array, view, PyBUF_ND | PyBUF_FORMAT) < 0)
        return -1;
    if (view->ndim == 1 && view->format && strcmp(view->format, "f") == 0)
        return 0;
    PyErr_Format(PyExc_ValueError, "%s: not one row of single precision", name);
    PyBuffer_Release(view);
    return -1;
}

/* In double precision and in one order, so that it is the same on every machine. */
static double cosine(const float *a, const float *b, Py_ssize_t n)
{
    double both[4] = {0.0}, one[4] = {0.0}, other[4] = {0.0};
    for (Py_ssize_t i = 0; i < n; i += 4) {
        for (Py_ssize_t k = 0; k < 4 && i + k < n; k++) {
            const double x = (double)a[i + k], y = (double)b[i + k];
            both[k] += x * y;
            one[k] += x * x;
            other[k] += y * y;
        }
    }
    const double lengths = ((one[0] + one[1]) + (one[2] + one[3])) *
                           ((other[0] + other[1]) + (other[2] + other[3]));
    return ((both[0] + both[1]) + (both[2] + both[3])) / sqrt(lengths);
}

PyObject *kernel_cosine(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Py_buffer one, other;
    double found = NAN;
    if (count_is("cosine", count, 2) < 0 || vector_open(&one, args[0], "one") < 0)
        return NULL;
    if (vector_open(&other, args[1], "other") < 0) {
        PyBuffer_Release(&one);
        return NULL;
    }
    if (one.shape[0] == other.shape[0]) {
        Py_BEGIN_ALLOW_THREADS
        found = cosine(one.buf, other.buf, one.shape[0]);
        Py_END_ALLOW_THREADS
    }
    PyBuffer_Release(&other);
    PyBuffer_Release(&one);
    return PyFloat_FromDouble(found);
}
