/* Walking distance by whole cells, and what of it reaches things. */
#include "walk.h"
#include "windows.h"
#include <math.h>

static const char *walk_in(Grid *steps, const Grid *passable, const Grid *seeds, long limit,
                           Py_ssize_t *reached)
{
    Walk walk = {0};
    const char *problem = walk_begin(&walk, passable);
    for (Py_ssize_t row = 0; row < seeds->rows && !problem; row++) {
        const uint8_t *seed = GRID_ROW(*seeds, uint8_t, row);
        Py_ssize_t col, last;
        if (!bytes_span(seed, seeds->cols, &col, &last))
            continue;
        for (; col < last; col++)
            if (seed[col])
                walk_start(&walk, row, col);
    }
    if (!problem) {
        walk_on(&walk, limit);
        for (Py_ssize_t row = 0; row < steps->rows; row++) {
            const uint16_t *state = walk.state + (row + 1) * walk.width + 1;
            float *out = GRID_ROW(*steps, float, row);
            for (Py_ssize_t col = 0; col < steps->cols; col++)
                out[col] = is_reached(state[col]) ? (float)(state[col] - 1) : INFINITY;
        }
        *reached = walk.count;
    }
    walk_end(&walk);
    return problem;
}

PyObject *kernel_walk(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'f', 1, "steps"}, {0, 0, "passable"}, {0, 0, "seeds"}};
    Grid grids[3];
    double limit;
    const char *problem = NULL;
    Py_ssize_t reached = 0;
    if (count_is("walk", count, 4) < 0 || numbers_of(&limit, args + 3, 1) < 0)
        return NULL;
    if (!(limit >= 0.0 && limit < OPEN - 1))
        return PyErr_Format(PyExc_ValueError, "limit: no number of steps from 0 to %d", OPEN - 2);
    if (grids_open(grids, args, specs, 3) < 0)
        return NULL;
    const int alike = grids_alike(grids, specs, 3);
    if (alike == 0) {
        Py_BEGIN_ALLOW_THREADS
        problem = walk_in(&grids[0], &grids[1], &grids[2], (long)limit, &reached);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 3);
    if (problem)
        return failed("walk", problem);
    return alike < 0 ? NULL : PyLong_FromSsize_t(reached);
}

/* The least in a square around a cell, as far as the grid goes; of its columns from `left` on. */
static float least_near(const Grid *away, const int32_t *cell, Py_ssize_t left, Py_ssize_t margin)
{
    const Py_ssize_t top = cell[0] > margin ? cell[0] - margin : 0;
    const Py_ssize_t bottom = cell[0] + margin < away->rows ? cell[0] + margin + 1 : away->rows;
    const Py_ssize_t right = cell[1] + margin < away->cols ? cell[1] + margin + 1 : away->cols;
    float least = INFINITY;
    for (Py_ssize_t r = top; r < bottom; r++) {
        const float *line = GRID_ROW(*away, float, r);
        for (Py_ssize_t c = left; c < right; c++)
            least = line[c] < least ? line[c] : least;
    }
    return least;
}

static float least_of(const Grid *away, const Grid *cells, Py_ssize_t start, Py_ssize_t end,
                      Py_ssize_t margin)
{
    float least = INFINITY;
    Py_ssize_t row = -1, col = -1; /* of the cell before */
    for (Py_ssize_t n = start; n < end; n++) {
        const int32_t *cell = GRID_ROW(*cells, int32_t, n);
        if (cell[0] < 0 || cell[0] >= away->rows || cell[1] < 0 || cell[1] >= away->cols)
            continue;
        /* Of a square one cell on only the last column is new. */
        const int goes_on = cell[0] == row && cell[1] == col + 1;
        const Py_ssize_t left = cell[1] + (goes_on ? margin : -margin);
        const float near = least_near(away, cell, left > 0 ? left : 0, margin);
        least = near < least ? near : least;
        row = cell[0];
        col = cell[1];
    }
    return least;
}

static void reach_things(Grid *nearest, const Grid *away, const Grid *cells, const Grid *starts,
                  Py_ssize_t margin)
{
    float *found = GRID_ROW(*nearest, float, 0);
    const int32_t *start = GRID_ROW(*starts, int32_t, 0);
    for (Py_ssize_t thing = 0; thing < nearest->cols; thing++) {
        const Py_ssize_t end = thing + 1 < nearest->cols ? start[thing + 1] : cells->rows;
        found[thing] = least_of(away, cells, start[thing], end, margin);
    }
}

static int in_order(const Grid *starts, Py_ssize_t count)
{
    const int32_t *start = GRID_ROW(*starts, int32_t, 0);
    for (Py_ssize_t n = 0; n < starts->cols; n++)
        if (start[n] < (n ? start[n - 1] : 0) || start[n] > count)
            return 0;
    return 1;
}

PyObject *kernel_reach_things(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {
        {'f', 1, "nearest"}, {'f', 0, "away"}, {'i', 0, "cells"}, {'i', 0, "starts"}};
    Grid grids[4];
    double margin;
    if (count_is("reach_things", count, 5) < 0 || numbers_of(&margin, args + 4, 1) < 0)
        return NULL;
    if (!(margin >= 0.0 && margin < 1e6))
        return failed("reach_things", "margin: no number of cells");
    if (grids_open(grids, args, specs, 4) < 0)
        return NULL;
    const int right = grids[0].rows == 1 && grids[3].rows == 1 && grids[0].cols == grids[3].cols &&
                      grids[2].cols == 2 && in_order(&grids[3], grids[2].rows);
    if (right) {
        Py_BEGIN_ALLOW_THREADS
        reach_things(&grids[0], &grids[1], &grids[2], &grids[3], (Py_ssize_t)margin);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 4);
    if (!right)
        return failed("reach_things", "cells, starts: not (N, 2), and (1, M) in order within them");
    Py_RETURN_NONE;
}
