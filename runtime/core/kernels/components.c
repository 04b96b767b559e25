/* Connected sets of cells, and what two sets share. See runtime/core/mapping/frontiers.py. */
#include "labels.h"
#include "windows.h"
#include <stdlib.h>
#include <string.h>

typedef struct {
    int32_t *label;  /* of each cell, padded by one on each side; 0: none */
    int32_t *parent; /* of each label */
    Py_ssize_t width;
    int32_t count; /* of labels, 0 included */
} Labels;

/* A label of what two are of, where 0 is none. */
static int32_t met(Labels *labels, int32_t a, int32_t b)
{
    if (!a || !b || a == b)
        return a ? a : b;
    return joined(labels->parent, a, b);
}

/* A label for each marked cell; the roots tell which are of one set. How many are marked. */
static Py_ssize_t label_cells(Labels *labels, const Grid *mask)
{
    Py_ssize_t marked = 0;
    for (Py_ssize_t row = 0; row < mask->rows; row++) {
        const uint8_t *cells = GRID_ROW(*mask, uint8_t, row);
        int32_t *here = labels->label + (row + 1) * labels->width + 1;
        const int32_t *above = here - labels->width;
        Py_ssize_t first, end;
        if (!bytes_span(cells, mask->cols, &first, &end))
            continue;
        for (Py_ssize_t col = first; col < end; col++) {
            if (!cells[col])
                continue;
            int32_t label = met(labels, here[col - 1], above[col]);
            label = met(labels, label, above[col - 1]);
            label = met(labels, label, above[col + 1]);
            if (!label) {
                label = labels->count++;
                labels->parent[label] = label;
            }
            here[col] = label;
            marked++;
        }
    }
    return marked;
}

typedef struct {
    Py_ssize_t row, col; /* of the first block of 2 x 2 cells that the set lies in */
    int32_t label, size;
} Set;

static int by_block(const void *a, const void *b)
{
    const Set *one = a, *other = b;
    if (one->row != other->row)
        return one->row < other->row ? -1 : 1;
    return (one->col > other->col) - (one->col < other->col);
}

/* The sets, in the order of their first blocks; afterwards parent of a root is where its cells
 * begin. */
static int32_t count_sets(Labels *labels, const Grid *mask, Set *sets)
{
    memset(sets, 0, (size_t)labels->count * sizeof *sets);
    for (int32_t label = 1; label < labels->count; label++)
        labels->parent[label] = root_of(labels->parent, label);
    for (Py_ssize_t row = 0; row < mask->rows; row++) {
        int32_t *here = labels->label + (row + 1) * labels->width + 1;
        for (Py_ssize_t col = 0; col < mask->cols; col++) {
            if (!here[col])
                continue;
            here[col] = labels->parent[here[col]];
            Set *set = &sets[here[col]];
            if (!set->size++)
                *set = (Set){row >> 1, col >> 1, here[col], 1};
            else if (row >> 1 == set->row && col >> 1 < set->col)
                set->col = col >> 1;
        }
    }
    int32_t found = 0;
    for (int32_t label = 1; label < labels->count; label++)
        if (sets[label].size)
            sets[found++] = sets[label];
    qsort(sets, (size_t)found, sizeof *sets, by_block);
    return found;
}

static void write_out(Labels *labels, const Grid *mask, const Set *sets, int32_t found,
                      Grid *cells, Grid *ends, const double *corner)
{
    int32_t *end = GRID_ROW(*ends, int32_t, 0), next = 0;
    for (int32_t n = 0; n < found; n++) {
        labels->parent[sets[n].label] = next;
        end[n] = next += sets[n].size;
    }
    for (Py_ssize_t row = 0; row < mask->rows; row++) {
        const int32_t *here = labels->label + (row + 1) * labels->width + 1;
        for (Py_ssize_t col = 0; col < mask->cols; col++) {
            if (here[col]) {
                int32_t *out = GRID_ROW(*cells, int32_t, labels->parent[here[col]]++);
                out[0] = (int32_t)(row + (Py_ssize_t)corner[0]);
                out[1] = (int32_t)(col + (Py_ssize_t)corner[1]);
            }
        }
    }
}

static const char *components(const Grid *mask, Grid *cells, Grid *ends, const double *corner,
                              int32_t *found)
{
    Labels labels = {.width = mask->cols + 2, .count = 1};
    if (!are_few(mask->rows + 2, labels.width))
        return TOO_MANY_CELLS;
    const size_t padded = (size_t)(labels.width * (mask->rows + 2));
    /* Of four cells in a square one alone can begin a set. */
    const size_t most = (size_t)((mask->rows / 2 + 1) * (mask->cols / 2 + 1)) + 1;
    Set *sets = malloc(most * sizeof *sets);
    const char *problem = NO_MEMORY;
    labels.label = calloc(padded, sizeof *labels.label);
    labels.parent = malloc(most * sizeof *labels.parent);
    if (labels.label && labels.parent && sets) {
        problem = NULL;
        if (label_cells(&labels, mask) != cells->rows)
            problem = "cells: not as many as are marked";
        else {
            *found = count_sets(&labels, mask, sets);
            write_out(&labels, mask, sets, *found, cells, ends, corner);
        }
    }
    free(labels.label);
    free(labels.parent);
    free(sets);
    return problem;
}

PyObject *kernel_components(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{0, 0, "mask"}, {'i', 1, "cells"}, {'i', 1, "ends"}};
    Grid grids[3];
    double corner[2];
    int32_t found = 0;
    const char *problem = "cells, ends: not (N, 2) and (1, N)";
    if (count_is("components", count, 5) < 0 || numbers_of(corner, args + 3, 2) < 0)
        return NULL;
    if (!(corner[0] >= 0.0 && corner[1] >= 0.0 && corner[0] + corner[1] < 1e9))
        return failed("components", "top, left: no cell of a grid");
    if (grids_open(grids, args, specs, 3) < 0)
        return NULL;
    if (grids[1].cols == 2 && grids[2].rows == 1 && grids[2].cols == grids[1].rows) {
        Py_BEGIN_ALLOW_THREADS
        problem = components(&grids[0], &grids[1], &grids[2], corner, &found);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 3);
    if (problem)
        return failed("components", problem);
    return PyLong_FromLong(found);
}

/* The box of cells (N, 2), so many cells wider. */
static Box box_round(const Grid *cells, Py_ssize_t margin)
{
    Box box = NO_BOX;
    for (Py_ssize_t n = 0; n < cells->rows; n++) {
        const int32_t *cell = GRID_ROW(*cells, int32_t, n);
        box_join_row(&box, cell[0], cell[1], (Py_ssize_t)cell[1] + 1);
    }
    return (Box){box.top - margin, box.bottom + margin, box.left - margin, box.right + margin};
}

static inline Py_ssize_t between(Py_ssize_t n, Py_ssize_t low, Py_ssize_t high)
{
    return n < low ? low : n > high ? high : n;
}

/* Where cells and the squares round others may meet. */
static Box box_of_both(const Grid *cells, const Grid *others, Py_ssize_t reach)
{
    const Box one = box_round(cells, 0), wide = box_round(others, reach);
    return (Box){one.top > wide.top ? one.top : wide.top,
                 one.bottom < wide.bottom ? one.bottom : wide.bottom,
                 one.left > wide.left ? one.left : wide.left,
                 one.right < wide.right ? one.right : wide.right};
}

static const char *shared(const Grid *cells, const Grid *others, Py_ssize_t reach,
                          Py_ssize_t *found)
{
    const Box box = box_of_both(cells, others, reach);
    if (!cells->rows || !others->rows || box.top >= box.bottom || box.left >= box.right)
        return NULL;
    if (box_cells(&box) < 0)
        return TOO_MANY_CELLS;
    const Py_ssize_t width = box.right - box.left;
    uint8_t *near = calloc((size_t)box_cells(&box), 1);
    if (!near)
        return NO_MEMORY;
    for (Py_ssize_t n = 0; n < others->rows; n++) {
        const int32_t *cell = GRID_ROW(*others, int32_t, n);
        const Py_ssize_t left = between(cell[1] - reach, box.left, box.right);
        const Py_ssize_t right = between(cell[1] + reach + 1, box.left, box.right);
        const Py_ssize_t bottom = between(cell[0] + reach + 1, box.top, box.bottom);
        for (Py_ssize_t row = between(cell[0] - reach, box.top, box.bottom); row < bottom; row++)
            memset(near + (row - box.top) * width + left - box.left, 1, (size_t)(right - left));
    }
    for (Py_ssize_t n = 0; n < cells->rows; n++) {
        const int32_t *cell = GRID_ROW(*cells, int32_t, n);
        if (cell[0] >= box.top && cell[0] < box.bottom && cell[1] >= box.left &&
            cell[1] < box.right)
            *found += near[(cell[0] - box.top) * width + cell[1] - box.left];
    }
    free(near);
    return NULL;
}

PyObject *kernel_shared(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'i', 0, "cells"}, {'i', 0, "others"}};
    Grid grids[2];
    double reach;
    Py_ssize_t found = 0;
    const char *problem = "cells, others: not (N, 2)";
    if (count_is("shared", count, 3) < 0 || numbers_of(&reach, args + 2, 1) < 0)
        return NULL;
    if (!(reach >= 0.0 && reach < 1e6))
        return failed("shared", "reach: no number of cells");
    if (grids_open(grids, args, specs, 2) < 0)
        return NULL;
    if (grids[0].cols == 2 && grids[1].cols == 2) {
        Py_BEGIN_ALLOW_THREADS
        problem = shared(&grids[0], &grids[1], (Py_ssize_t)reach, &found);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 2);
    return problem ? failed("shared", problem) : PyLong_FromSsize_t(found);
}
