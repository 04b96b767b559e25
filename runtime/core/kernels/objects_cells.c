/* The map cells under things: which they are, which of them are strays, how near two are. */
#include "objects.h"
#include <math.h>
#include <stdlib.h>

enum { MOST_CELLS = 1000000000 }; /* from a map's corner */

static inline int32_t cell_at(double scaled)
{
    const int32_t cut = (int32_t)scaled;
    return cut - (scaled < cut);
}

/* How many of them are nowhere on a map. */
static int32_t cells_at(const double *restrict at_m, size_t n, double from_m, double cell_m,
                       int32_t *restrict cells)
{
    int32_t nowhere = 0;
    for (size_t i = 0; i < n; i++) {
        const double scaled = (at_m[i] - from_m) / cell_m;
        const int there = fabs(scaled) < MOST_CELLS;
        nowhere += !there;
        cells[i] = cell_at(there ? scaled : 0.0);
    }
    return nowhere;
}

const char *footprint(const Frame *frame, const Points *points, Footprint *into, int32_t *scratch)
{
    const size_t n = points->n;
    const double cell_m = frame->cell_m;
    int32_t *col = scratch, *row = scratch + n;
    if (cells_at(points->x, n, frame->x0_m, cell_m, col) +
        cells_at(points->y, n, frame->y0_m, cell_m, row))
        return "points that are nowhere on a map";
    const int32_t left = cell_at((points->across.low - frame->x0_m) / cell_m);
    const int32_t top = cell_at((points->along.low - frame->y0_m) / cell_m);
    const int32_t right = cell_at((points->across.high - frame->x0_m) / cell_m);
    const int32_t bottom = cell_at((points->along.high - frame->y0_m) / cell_m);
    const size_t width = (size_t)(right - left) + 1, height = (size_t)(bottom - top) + 1;
    uint8_t *held = calloc(width * height, 1);
    if (!held)
        return "out of memory";
    for (size_t i = 0; i < n; i++)
        held[(size_t)(row[i] - top) * width + (size_t)(col[i] - left)] = 1;
    into->count = 0;
    for (size_t r = 0; r < height; r++) {
        const double high = ((double)r + (top + 0.5)) * cell_m + frame->y0_m;
        for (size_t c = 0; c < width; c++) {
            if (!held[r * width + c])
                continue;
            into->x[into->count] = ((double)c + (left + 0.5)) * cell_m + frame->x0_m;
            into->y[into->count++] = high;
        }
    }
    free(held);
    return NULL;
}

void without_strays(Footprint *cells, Strays strays, double *scratch)
{
    const size_t n = cells->count, half = n / 2;
    double *away = scratch, *order = scratch + n, reach;
    const double x = median(cells->x, n, order); /* in scan order the rows ascend */
    const double y = (cells->y[(n - 1) / 2] + cells->y[n / 2]) / 2.0;
    for (size_t i = 0; i < n; i++)
        away[i] = hypot(cells->x[i] - x, cells->y[i] - y);
    at_ranks(away, n, &half, 1, &reach, order);
    reach = strays.times * reach > strays.least_m ? strays.times * reach : strays.least_m;
    cells->count = 0;
    for (size_t i = 0; i < n; i++) {
        if (!(away[i] <= reach))
            continue;
        cells->x[cells->count] = cells->x[i];
        cells->y[cells->count++] = cells->y[i];
    }
}

PyObject *packed(const Footprint *cells)
{
    PyObject *bytes = PyBytes_FromStringAndSize(NULL, (Py_ssize_t)(cells->count * 16));
    double *xy = bytes ? (double *)(void *)PyBytes_AsString(bytes) : NULL;
    for (size_t i = 0; xy && i < cells->count; i++) {
        xy[2 * i] = cells->x[i];
        xy[2 * i + 1] = cells->y[i];
    }
    return bytes;
}

int cells_open(Grid *grid, PyObject *array, const char *name)
{
    if (grid_open(grid, array, 'd', 0, name) < 0)
        return -1;
    if (grid->rows > 0 && grid->rows < INT32_MAX && grid->cols == 2)
        return 0;
    PyErr_Format(PyExc_ValueError, "%s: (%zd, %zd), not (N, 2), N at least 1", name, grid->rows,
                 grid->cols);
    grid_close(grid);
    return -1;
}

/* Two sets of cells made one. */
typedef struct {
    Footprint cells;
    int whole; /* none of it was a stray */
    int kept;  /* nothing but the first */
    double x, y;
    void *memory;
} Union;

static int equals(const Footprint *cells, const Grid *other)
{
    if (cells->count != (size_t)other->rows)
        return 0;
    for (size_t i = 0; i < cells->count; i++) {
        const double *xy = GRID_ROW(*other, double, (Py_ssize_t)i);
        if (cells->x[i] != xy[0] || cells->y[i] != xy[1])
            return 0;
    }
    return 1;
}

/* `settled`: the first has no strays, and is kept if there is nothing new. */
static const char *unite(const Grid *first, const Grid *other, const Frame *frame, Strays strays,
                         int settled, Union *into)
{
    const size_t n = (size_t)first->rows + (size_t)other->rows;
    double *at = into->memory = malloc(n * (6 * sizeof *at + 2 * sizeof(int32_t)));
    if (!at)
        return "out of memory";
    double *x = at, *y = at + n, *scratch = at + 4 * n;
    into->cells = (Footprint){at + 2 * n, at + 3 * n, 0};
    for (size_t i = 0; i < n; i++) {
        const Py_ssize_t row = (Py_ssize_t)i;
        const double *xy = row < first->rows ? GRID_ROW(*first, double, row)
                                             : GRID_ROW(*other, double, row - first->rows);
        x[i] = xy[0];
        y[i] = xy[1];
    }
    const Points points = {x, y, n, range_of(x, n), range_of(y, n)};
    const char *problem = footprint(frame, &points, &into->cells, (int32_t *)(at + 6 * n));
    if (problem)
        return problem;
    into->kept = settled && equals(&into->cells, first);
    if (into->kept)
        return NULL;
    const size_t all = into->cells.count;
    without_strays(&into->cells, strays, scratch);
    const size_t left = into->cells.count;
    into->whole = left == all;
    into->x = median(into->cells.x, left, scratch);
    into->y = (into->cells.y[(left - 1) / 2] + into->cells.y[left / 2]) / 2.0;
    return NULL;
}

PyObject *kernel_joined_cells(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    Grid first, other;
    Union found = {.memory = NULL};
    double f[3], s[2];
    (void)module;
    if (count != 5)
        return PyErr_Format(PyExc_TypeError, "joined_cells takes 5 arguments, not %zd", count);
    const int settled = PyObject_IsTrue(args[4]);
    if (settled < 0 || numbers_open(f, 3, args[2], "frame") < 0 ||
        numbers_open(s, 2, args[3], "strays") < 0 || cells_open(&first, args[0], "cells") < 0)
        return NULL;
    if (cells_open(&other, args[1], "others") < 0) {
        grid_close(&first);
        return NULL;
    }
    const Frame frame = {f[0], f[1], f[2]};
    const Strays strays = {s[0], s[1]};
    const char *problem = "cells of no size, or strays that may be most";
    if (can_be(frame, strays)) {
        Py_BEGIN_ALLOW_THREADS
        problem = unite(&first, &other, &frame, strays, settled, &found);
        Py_END_ALLOW_THREADS
    }
    grid_close(&other);
    grid_close(&first);
    PyObject *told = NULL;
    if (problem)
        PyErr_Format(PyExc_ValueError, "joined_cells: %s", problem);
    else if (found.kept)
        told = Py_NewRef(Py_None);
    else
        told = Py_BuildValue("(Nidd)", packed(&found.cells), found.whole, found.x, found.y);
    free(found.memory);
    return told;
}

/* How near the nearest cell is to a point, m: to the last bit what `hypot` says of it. */
static double nearest(const Grid *cells, double x, double y)
{
    double least = INFINITY, found = INFINITY;
    for (Py_ssize_t n = 0; n < cells->rows; n++) {
        const double *xy = GRID_ROW(*cells, double, n), dx = xy[0] - x, dy = xy[1] - y;
        const double square = dx * dx + dy * dy;
        if (square > least * (1.0 + 1e-9))
            continue; /* what is rounded otherwise may be nearer by a bit */
        least = square < least ? square : least;
        const double away = hypot(dx, dy);
        found = away < found ? away : found;
    }
    return found;
}

PyObject *kernel_cells_gap(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    Grid one, other;
    double a[2], b[2], gap;
    (void)module;
    if (count != 4)
        return PyErr_Format(PyExc_TypeError, "cells_gap takes 4 arguments, not %zd", count);
    if (numbers_open(a, 2, args[1], "xy") < 0 || numbers_open(b, 2, args[3], "other_xy") < 0 ||
        cells_open(&one, args[0], "cells") < 0)
        return NULL;
    if (cells_open(&other, args[2], "other_cells") < 0) {
        grid_close(&one);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    const double theirs = nearest(&one, b[0], b[1]), mine = nearest(&other, a[0], a[1]);
    gap = theirs < mine ? theirs : mine;
    Py_END_ALLOW_THREADS
    grid_close(&other);
    grid_close(&one);
    return PyFloat_FromDouble(gap);
}
