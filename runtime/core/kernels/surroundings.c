/* Means of layers of a map over what can be walked to from sets of cells. */
#include "walk.h"
#include "windows.h"
#include <string.h>

typedef struct {
    Grid found, layers, passable, cells, ends; /* layers are stacked */
    long limit;
} Around;

/* The box of a set's cells, and as far around it as the walk leads. */
static Box box_of_walk(const Around *around, Py_ssize_t start, Py_ssize_t end)
{
    Box box = NO_BOX;
    for (Py_ssize_t n = start; n < end; n++) {
        const int32_t *cell = GRID_ROW(around->cells, int32_t, n);
        box_join_row(&box, cell[0], cell[1], cell[1] + 1);
    }
    return box_widened(&box, around->limit, &around->passable);
}

/* Sums cell by cell, in the order of the rows. */
static void mean_of_walk(const Around *around, const Walk *walk, const Box *box, float *mean)
{
    const Py_ssize_t layers = around->found.cols;
    const Py_ssize_t apart = around->layers.stride * around->passable.rows; /* bytes */
    memset(mean, 0, (size_t)layers * sizeof *mean);
    for (Py_ssize_t row = box->top; row < box->bottom; row++) {
        const uint16_t *state = walk->state + (row - box->top + 1) * walk->width + 1;
        const float *value = GRID_ROW(around->layers, float, row) + box->left;
        for (Py_ssize_t col = 0; col < box->right - box->left; col++) {
            if (!is_reached(state[col]))
                continue;
            const char *at = (const char *)(value + col);
            for (Py_ssize_t layer = 0; layer < layers; layer++, at += apart)
                mean[layer] += *(const float *)at;
        }
    }
    for (Py_ssize_t layer = 0; layer < layers; layer++)
        mean[layer] /= (float)walk->count;
}

static const char *means(const Around *around)
{
    const int32_t *ends = GRID_ROW(around->ends, int32_t, 0);
    for (Py_ssize_t set = 0; set < around->ends.cols; set++) {
        const Py_ssize_t start = set ? ends[set - 1] : 0;
        const Box box = box_of_walk(around, start, ends[set]);
        Grid part = around->passable;
        Walk walk = {0};
        part.at = GRID_ROW(part, char, box.top) + box.left;
        part.rows = box.bottom - box.top;
        part.cols = box.right - box.left;
        const char *problem = walk_begin(&walk, &part);
        if (!problem) {
            for (Py_ssize_t n = start; n < ends[set]; n++) {
                const int32_t *cell = GRID_ROW(around->cells, int32_t, n);
                walk_start(&walk, cell[0] - box.top, cell[1] - box.left);
            }
            walk_on(&walk, around->limit);
            mean_of_walk(around, &walk, &box, GRID_ROW(around->found, float, set));
        }
        walk_end(&walk);
        if (problem)
            return problem;
    }
    return NULL;
}

static int fits(const Around *around)
{
    const Grid *cells = &around->cells, *ends = &around->ends, *map = &around->passable;
    if (cells->cols != 2 || ends->rows != 1 || ends->cols != around->found.rows ||
        around->layers.cols != map->cols || around->layers.rows != around->found.cols * map->rows)
        return 0;
    for (Py_ssize_t n = 0; n < ends->cols; n++) {
        const int32_t *end = GRID_ROW(*ends, int32_t, 0) + n;
        if (*end <= (n ? end[-1] : 0) || *end > cells->rows)
            return 0;
    }
    for (Py_ssize_t n = 0; n < cells->rows; n++) {
        const int32_t *cell = GRID_ROW(*cells, int32_t, n);
        if (cell[0] < 0 || cell[0] >= map->rows || cell[1] < 0 || cell[1] >= map->cols)
            return 0;
    }
    return 1;
}

PyObject *kernel_means(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'f', 1, "means"}, {'f', 0, "layers"}, {0, 0, "passable"},
                                     {'i', 0, "cells"}, {'i', 0, "ends"}};
    Grid grids[5];
    double limit;
    const char *problem = "cells, ends: not sets of cells of the layers' map";
    if (count_is("means", count, 6) < 0 || numbers_of(&limit, args + 5, 1) < 0)
        return NULL;
    if (!(limit >= 0.0 && limit < OPEN - 1))
        return PyErr_Format(PyExc_ValueError, "limit: no number of steps from 0 to %d", OPEN - 2);
    if (grids_open(grids, args, specs, 5) < 0)
        return NULL;
    const Around around = {grids[0], grids[1], grids[2], grids[3], grids[4], (long)limit};
    if (fits(&around)) {
        Py_BEGIN_ALLOW_THREADS
        problem = means(&around);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 5);
    if (problem)
        return failed("means", problem);
    Py_RETURN_NONE;
}
