/* Windows of grids. */
#include "windows.h"
#include <string.h>

int box_of(Box *box, PyObject *const *args, const Grid *grid)
{
    Py_ssize_t ends[4];
    if (wholes_of(ends, args, 4) < 0)
        return -1;
    *box = (Box){ends[0], ends[1], ends[2], ends[3]};
    if (0 <= box->top && box->top <= box->bottom && box->bottom <= grid->rows && 0 <= box->left &&
        box->left <= box->right && box->right <= grid->cols)
        return 0;
    PyErr_Format(PyExc_ValueError, "window: rows %zd to %zd, columns %zd to %zd of (%zd, %zd)",
                 ends[0], ends[1], ends[2], ends[3], grid->rows, grid->cols);
    return -1;
}

PyObject *box_as_tuple(const Box *box)
{
    if (box->top >= box->bottom || box->left >= box->right)
        Py_RETURN_NONE;
    return Py_BuildValue("nnnn", box->top, box->bottom, box->left, box->right);
}

Box box_widened(const Box *box, Py_ssize_t margin, const Grid *grid)
{
    Box wide = {box->top - margin, box->bottom + margin, box->left - margin, box->right + margin};
    wide.top = wide.top > 0 ? wide.top : 0;
    wide.left = wide.left > 0 ? wide.left : 0;
    wide.bottom = wide.bottom < grid->rows ? wide.bottom : grid->rows;
    wide.right = wide.right < grid->cols ? wide.right : grid->cols;
    return wide;
}

int bytes_span(const uint8_t *bytes, Py_ssize_t n, Py_ssize_t *first, Py_ssize_t *end)
{
    Py_ssize_t at = 0;
    uint64_t eight;
    for (; at + 8 <= n; at += 8) {
        memcpy(&eight, bytes + at, 8);
        if (eight)
            break;
    }
    while (at < n && !bytes[at])
        at++;
    if (at == n)
        return 0;
    *first = at;
    for (at = n; at >= 8; at -= 8) {
        memcpy(&eight, bytes + at - 8, 8);
        if (eight)
            break;
    }
    while (!bytes[at - 1])
        at--;
    *end = at;
    return 1;
}
