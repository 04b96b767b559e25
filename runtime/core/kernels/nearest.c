/* The cell of a set, or close by it, that is nearest on foot. See runtime/core/world.py. */
#include "windows.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const Grid *arrival, *cells;
    Py_ssize_t start, end; /* of the set's cells */
    Py_ssize_t snap, first_row, first_col; /* before which there is no cell */
} Search;

typedef struct {
    int32_t row, col;
    double away;
} Found;

static double at(const Search *search, Py_ssize_t row, Py_ssize_t col)
{
    const Grid *arrival = search->arrival;
    return row >= 0 && row < arrival->rows && col >= 0 && col < arrival->cols
               ? GRID_ROW(*arrival, double, row)[col]
               : INFINITY;
}

/* The first of the set's nearest. */
static Found of_set(const Search *search)
{
    const int32_t *first = GRID_ROW(*search->cells, int32_t, search->start);
    Found found = {first[0], first[1], INFINITY};
    for (Py_ssize_t n = search->start; n < search->end; n++) {
        const int32_t *cell = GRID_ROW(*search->cells, int32_t, n);
        const double away = at(search, cell[0], cell[1]);
        if (away < found.away)
            found = (Found){cell[0], cell[1], away};
    }
    return found;
}

static Box box_of_set(const Search *search)
{
    Box box = {PY_SSIZE_T_MAX, PY_SSIZE_T_MIN, PY_SSIZE_T_MAX, PY_SSIZE_T_MIN};
    for (Py_ssize_t n = search->start; n < search->end; n++) {
        const int32_t *cell = GRID_ROW(*search->cells, int32_t, n);
        box.top = cell[0] < box.top ? cell[0] : box.top;
        box.bottom = cell[0] > box.bottom ? cell[0] : box.bottom;
        box.left = cell[1] < box.left ? cell[1] : box.left;
        box.right = cell[1] > box.right ? cell[1] : box.right;
    }
    box.top = box.top - search->snap > search->first_row ? box.top - search->snap
                                                         : search->first_row;
    box.left = box.left - search->snap > search->first_col ? box.left - search->snap
                                                           : search->first_col;
    box.bottom += search->snap + 1;
    box.right += search->snap + 1;
    return box;
}

/* Marks the squares round the set's cells, as far as the box goes. */
static void mark_near(const Search *search, const Box *box, uint8_t *near)
{
    const Py_ssize_t width = box->right - box->left;
    for (Py_ssize_t n = search->start; n < search->end; n++) {
        const int32_t *cell = GRID_ROW(*search->cells, int32_t, n);
        Py_ssize_t row = cell[0] - search->snap, left = cell[1] - search->snap;
        row = row > box->top ? row : box->top;
        left = left > box->left ? left : box->left;
        for (; row <= cell[0] + search->snap; row++)
            if (left <= cell[1] + search->snap)
                memset(near + (row - box->top) * width + left - box->left, 1,
                       (size_t)(cell[1] + search->snap + 1 - left));
    }
}

/* The first of the nearest in the squares round the set's cells; where none is reached the first
 * of all. */
static const char *close_by(const Search *search, Found *found)
{
    const Box box = box_of_set(search);
    const Py_ssize_t width = box.right - box.left;
    uint8_t *near = NULL;
    if (box.top >= box.bottom || box.left >= box.right)
        return NULL;
    if (box_cells(&box) < 0 || box.bottom > INT32_MAX || box.right > INT32_MAX)
        return TOO_MANY_CELLS;
    near = calloc((size_t)box_cells(&box), 1);
    if (!near)
        return NO_MEMORY;
    mark_near(search, &box, near);
    int any = 0;
    for (Py_ssize_t row = box.top; row < box.bottom; row++) {
        for (Py_ssize_t col = box.left; col < box.right; col++) {
            if (!near[(row - box.top) * width + col - box.left])
                continue;
            const double away = at(search, row, col);
            if (!any || away < found->away)
                *found = (Found){(int32_t)row, (int32_t)col, away};
            any = 1;
        }
    }
    free(near);
    return NULL;
}

static const char *nearest(const Grid *ends, Search *search, Grid *places, Grid *away)
{
    const int32_t *end = GRID_ROW(*ends, int32_t, 0);
    for (Py_ssize_t n = 0; n < ends->cols; n++) {
        search->start = n ? end[n - 1] : 0;
        search->end = end[n];
        Found found = of_set(search);
        const char *problem = isinf(found.away) ? close_by(search, &found) : NULL;
        if (problem)
            return problem;
        GRID_ROW(*places, int32_t, n)[0] = found.row;
        GRID_ROW(*places, int32_t, n)[1] = found.col;
        GRID_ROW(*away, double, 0)[n] = found.away;
    }
    return NULL;
}

static int sets_are_right(const Grid *cells, const Grid *ends, const Grid *places, const Grid *away)
{
    if (cells->cols != 2 || ends->rows != 1 || places->cols != 2 || away->rows != 1 ||
        places->rows != ends->cols || away->cols != ends->cols)
        return 0;
    const int32_t *end = GRID_ROW(*ends, int32_t, 0);
    for (Py_ssize_t n = 0; n < ends->cols; n++)
        if (end[n] <= (n ? end[n - 1] : 0) || end[n] > cells->rows)
            return 0;
    return 1;
}

PyObject *kernel_nearest(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'d', 0, "arrival"}, {'i', 0, "cells"}, {'i', 0, "ends"},
                                     {'i', 1, "places"},  {'d', 1, "away"}};
    Grid grids[5];
    double numbers[3];
    const char *problem = "cells, ends: not (N, 2), and (1, M) rising in it";
    if (count_is("nearest", count, 8) < 0 || numbers_of(numbers, args + 5, 3) < 0)
        return NULL;
    if (!(numbers[0] >= 0.0 && numbers[0] < 1e6 && fabs(numbers[1]) + fabs(numbers[2]) < 1e9))
        return failed("nearest", "snap, first: no number of cells, or no cell");
    if (grids_open(grids, args, specs, 5) < 0)
        return NULL;
    if (sets_are_right(&grids[1], &grids[2], &grids[3], &grids[4])) {
        Search search = {&grids[0], &grids[1], 0, 0, (Py_ssize_t)numbers[0],
                         (Py_ssize_t)numbers[1], (Py_ssize_t)numbers[2]};
        Py_BEGIN_ALLOW_THREADS
        problem = nearest(&grids[2], &search, &grids[3], &grids[4]);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 5);
    if (problem)
        return failed("nearest", problem);
    Py_RETURN_NONE;
}
