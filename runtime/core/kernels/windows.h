/* Windows of grids. */
#ifndef RFNAV_WINDOWS_H
#define RFNAV_WINDOWS_H
#include "arguments.h"

/* Rows from top on and before bottom, columns from left on and before right. */
typedef struct {
    Py_ssize_t top, bottom, left, right;
} Box;

#define NO_BOX ((Box){PY_SSIZE_T_MAX, 0, PY_SSIZE_T_MAX, 0}) /* which holds nothing */

/* Reads top, bottom, left, right of a window of a grid; -1 with TypeError or OverflowError set, or
 * with ValueError where it reaches beyond. */
int box_of(Box *box, PyObject *const *args, const Grid *grid);

/* As four numbers, or None where it holds nothing. */
PyObject *box_as_tuple(const Box *box);

/* The box and so many cells around it, as far as the grid reaches. */
Box box_widened(const Box *box, Py_ssize_t margin, const Grid *grid);

/* Its cells; -1 where they are more than an int32_t numbers. It holds something. */
static inline Py_ssize_t box_cells(const Box *box)
{
    const Py_ssize_t rows = box->bottom - box->top, cols = box->right - box->left;
    return are_few(rows, cols) ? rows * cols : -1;
}

static inline void box_join_row(Box *box, Py_ssize_t row, Py_ssize_t left, Py_ssize_t right)
{
    box->top = row < box->top ? row : box->top;
    box->bottom = row + 1 > box->bottom ? row + 1 : box->bottom;
    box->left = left < box->left ? left : box->left;
    box->right = right > box->right ? right : box->right;
}

/* Whether one of n bytes is not 0, and before which the first and after which the last. */
int bytes_span(const uint8_t *bytes, Py_ssize_t n, Py_ssize_t *first, Py_ssize_t *end);

#endif
