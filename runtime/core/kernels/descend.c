/* What is done with arrival times: the way down them, and up to which of them a change leaves all
 * as it was. */
#include "arguments.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether a neighbour lies lower: the steepest of the eight, the first in scan order of equals. */
static int lower(const Grid *arrival, Py_ssize_t *row, Py_ssize_t *col)
{
    const Py_ssize_t at_row = *row, at_col = *col;
    const double here = GRID_ROW(*arrival, double, at_row)[at_col];
    double steepest = 0.0;
    for (Py_ssize_t r = at_row - 1; r <= at_row + 1; r++) {
        for (Py_ssize_t c = at_col - 1; c <= at_col + 1; c++) {
            if (r < 0 || c < 0 || r >= arrival->rows || c >= arrival->cols)
                continue;
            double falls = here - GRID_ROW(*arrival, double, r)[c];
            if (r != at_row && c != at_col)
                falls *= 0.70710678118654752; /* a step is longer by the root of 2 */
            if (falls > steepest) {
                steepest = falls;
                *row = r;
                *col = c;
            }
        }
    }
    return steepest > 0.0;
}

/* From a cell of the grid always on to where it falls most steeply, for at most so many cells in
 * all; how many they are. */
static Py_ssize_t descend(const Grid *arrival, Py_ssize_t row, Py_ssize_t col, Py_ssize_t most,
                          int32_t *cells)
{
    Py_ssize_t found = 0;
    while (found < most) {
        cells[2 * found] = (int32_t)row;
        cells[2 * found + 1] = (int32_t)col;
        found++;
        if (GRID_ROW(*arrival, double, row)[col] <= 0.0 || !lower(arrival, &row, &col))
            break;
    }
    return found;
}

PyObject *kernel_descend(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid arrival;
    Py_ssize_t wholes[3], found = 0;
    if (count_is("descend", count, 4) < 0 || wholes_of(wholes, args + 1, 3) < 0)
        return NULL;
    const Py_ssize_t row = wholes[0], col = wholes[1], limit = wholes[2];
    if (limit < 0)
        return failed("descend", "limit: below 0");
    if (grid_open(&arrival, args[0], (GridSpec){'d', 0, "arrival"}) < 0)
        return NULL;
    const int starts = row >= 0 && col >= 0 && row < arrival.rows && col < arrival.cols &&
                       isfinite(GRID_ROW(arrival, double, row)[col]);
    const Py_ssize_t all = arrival.rows * arrival.cols; /* no cell is passed twice */
    const Py_ssize_t most = !starts ? 0 : limit < all ? limit + 1 : all;
    int32_t *cells = malloc((size_t)(2 * most + 2) * sizeof *cells);
    if (cells) {
        Py_BEGIN_ALLOW_THREADS
        found = descend(&arrival, row, col, most, cells);
        Py_END_ALLOW_THREADS
    }
    grid_close(&arrival);
    if (!cells)
        return PyErr_NoMemory();
    const Py_ssize_t bytes = 2 * found * (Py_ssize_t)sizeof *cells;
    PyObject *path = PyBytes_FromStringAndSize((char *)cells, bytes);
    free(cells);
    return path;
}

/* The earliest arrival at a cell and its four neighbours. */
static double earliest(const Grid *arrival, Py_ssize_t row, Py_ssize_t col, double so_far)
{
    const double *t = GRID_ROW(*arrival, double, row);
    double least = so_far < t[col] ? so_far : t[col];
    if (col > 0 && t[col - 1] < least)
        least = t[col - 1];
    if (col + 1 < arrival->cols && t[col + 1] < least)
        least = t[col + 1];
    if (row > 0 && GRID_ROW(*arrival, double, row - 1)[col] < least)
        least = GRID_ROW(*arrival, double, row - 1)[col];
    if (row + 1 < arrival->rows && GRID_ROW(*arrival, double, row + 1)[col] < least)
        least = GRID_ROW(*arrival, double, row + 1)[col];
    return least;
}

static double touched(const Grid *arrival, Grid *before, const Grid *speed)
{
    double least = INFINITY;
    const size_t bytes = (size_t)speed->cols * sizeof(float);
    for (Py_ssize_t row = 0; row < speed->rows; row++) {
        float *was = GRID_ROW(*before, float, row);
        const float *is = GRID_ROW(*speed, float, row);
        if (memcmp(was, is, bytes) == 0)
            continue; /* mostly */
        for (Py_ssize_t col = 0; col < speed->cols; col++)
            if (was[col] != is[col])
                least = earliest(arrival, row, col, least);
        memcpy(was, is, bytes);
    }
    return least;
}

PyObject *kernel_touched(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'d', 0, "arrival"}, {'f', 1, "before"}, {'f', 0, "speed"}};
    Grid grids[3];
    if (count_is("touched", count, 3) < 0 || grids_open(grids, args, specs, 3) < 0)
        return NULL;
    double least = INFINITY;
    const int alike = grids_alike(grids, specs, 3);
    if (alike == 0) {
        Py_BEGIN_ALLOW_THREADS
        least = touched(&grids[0], &grids[1], &grids[2]);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 3);
    return alike < 0 ? NULL : PyFloat_FromDouble(least);
}
