/* Windows of grids, and kernels' arguments: several arrays, numbers, a window. */
#ifndef RFNAV_WINDOWS_H
#define RFNAV_WINDOWS_H
#include "kernels.h"

/* How an argument that is an array must be; see grid_open. */
typedef struct {
    char kind;
    int writable;
    const char *name;
} GridSpec;

/* Opens several arrays, or none of them. Where `as` is not NULL, all must have its shape, or 0
 * comes before its specification. */
int grids_open(Grid *grids, PyObject *const *args, const GridSpec *specs, int count);
void grids_close(Grid *grids, int count);

/* -1 with ValueError set where grids from the first on are not all of one shape. */
int grids_alike(const Grid *grids, const GridSpec *specs, int count);

/* Reads numbers; -1 with TypeError set. */
int numbers_of(double *numbers, PyObject *const *args, int count);

/* -1 with TypeError set where the count of arguments is another. */
int count_is(const char *kernel, Py_ssize_t count, Py_ssize_t wanted);

/* Rows from top on and before bottom, columns from left on and before right. */
typedef struct {
    Py_ssize_t top, bottom, left, right;
} Box;

#define NO_BOX ((Box){PY_SSIZE_T_MAX, 0, PY_SSIZE_T_MAX, 0}) /* which holds nothing */

/* Reads top, bottom, left, right of a window of a grid; -1 with ValueError set where it reaches
 * beyond. */
int box_of(Box *box, PyObject *const *args, const Grid *grid);

/* As four numbers, or None where it holds nothing. */
PyObject *box_as_tuple(const Box *box);

/* The box and so many cells around it, as far as the grid reaches. */
Box box_widened(const Box *box, Py_ssize_t margin, const Grid *grid);

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
