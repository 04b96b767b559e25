/* The map cells under things: which they are, which of them are strays, how near two are. */
#include "objects.h"
#include "windows.h"
#include <math.h>
#include <stdlib.h>

const char NOWHERE[] = "points that are nowhere on a map";

enum { MOST_CELLS = 1000000000 }; /* from a map's corner */
enum { MOST_HELD = 1 << 24 };     /* cells of a box, of which each is looked at */

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

/* Takes a cell for one under points. */
static inline void add_cell(const Frame *frame, Footprint *into, int64_t row, int64_t col)
{
    into->x[into->count] = ((double)col + 0.5) * frame->cell_m + frame->x0_m;
    into->y[into->count++] = ((double)row + 0.5) * frame->cell_m + frame->y0_m;
}

/* Cells of a box that is not much larger than what is in it: each of it is looked at. */
static const char *collect(const Frame *frame, const int32_t *row, const int32_t *col, size_t n,
                           const Box *box, Footprint *into)
{
    const Py_ssize_t width = box->right - box->left;
    uint8_t *held = calloc((size_t)box_cells(box), 1);
    if (!held)
        return NO_MEMORY;
    for (size_t i = 0; i < n; i++)
        held[(row[i] - box->top) * width + col[i] - box->left] = 1;
    for (Py_ssize_t r = box->top; r < box->bottom; r++)
        for (Py_ssize_t c = box->left; c < box->right; c++)
            if (held[(r - box->top) * width + c - box->left])
                add_cell(frame, into, r, c);
    free(held);
    return NULL;
}

typedef struct {
    int32_t row, col;
} Cell;

static int in_scan_order(const void *a, const void *b)
{
    const Cell *one = a, *other = b;
    if (one->row != other->row)
        return one->row < other->row ? -1 : 1;
    return (one->col > other->col) - (one->col < other->col);
}

/* The same of any box. */
static const char *collect_far(const Frame *frame, const int32_t *row, const int32_t *col,
                               size_t n, Footprint *into)
{
    Cell *cells = malloc(n * sizeof *cells);
    if (!cells)
        return NO_MEMORY;
    for (size_t i = 0; i < n; i++)
        cells[i] = (Cell){row[i], col[i]};
    qsort(cells, n, sizeof *cells, in_scan_order);
    for (size_t i = 0; i < n; i++)
        if (!i || in_scan_order(cells + i - 1, cells + i) != 0)
            add_cell(frame, into, cells[i].row, cells[i].col);
    free(cells);
    return NULL;
}

const char *footprint(const Frame *frame, const Points *points, Footprint *into, int32_t *scratch)
{
    const size_t n = points->n;
    const double cell_m = frame->cell_m;
    int32_t *col = scratch, *row = scratch + n;
    if (cells_at(points->x, n, frame->x0_m, cell_m, col) +
        cells_at(points->y, n, frame->y0_m, cell_m, row))
        return NOWHERE;
    const Box box = {cell_at((points->along.low - frame->y0_m) / cell_m),
                     cell_at((points->along.high - frame->y0_m) / cell_m) + 1,
                     cell_at((points->across.low - frame->x0_m) / cell_m),
                     cell_at((points->across.high - frame->x0_m) / cell_m) + 1};
    const Py_ssize_t held = box_cells(&box);
    into->count = 0;
    return held >= 0 && held <= MOST_HELD ? collect(frame, row, col, n, &box, into)
                                          : collect_far(frame, row, col, n, into);
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
        return NO_MEMORY;
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

/* (the cells, whether none was a stray, the medians); None where the first are kept. */
static PyObject *united(const Union *found)
{
    if (found->kept)
        Py_RETURN_NONE;
    PyObject *whole = PyBool_FromLong(found->whole);
    return Py_BuildValue("(NNdd)", packed(&found->cells), whole, found->x, found->y);
}

PyObject *kernel_joined_cells(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid first, other;
    Union found = {.memory = NULL};
    double f[3], s[2];
    if (count_is("joined_cells", count, 5) < 0)
        return NULL;
    const int settled = PyObject_IsTrue(args[4]);
    if (settled < 0 || numbers_in(f, 3, args[2], "frame") < 0 ||
        numbers_in(s, 2, args[3], "strays") < 0)
        return NULL;
    const Frame frame = {f[0], f[1], f[2]};
    const Strays strays = {s[0], s[1]};
    if (!can_be(frame, strays))
        return failed("joined_cells", "frame, strays: no size, or strays may be most");
    if (points_open(&first, args[0], "cells") < 0)
        return NULL;
    if (points_open(&other, args[1], "others") < 0) {
        grid_close(&first);
        return NULL;
    }
    const char *problem;
    Py_BEGIN_ALLOW_THREADS
    problem = unite(&first, &other, &frame, strays, settled, &found);
    Py_END_ALLOW_THREADS
    grid_close(&other);
    grid_close(&first);
    PyObject *told = problem ? failed("joined_cells", problem) : united(&found);
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

PyObject *kernel_cells_gap(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid one, other;
    double a[2], b[2], gap;
    if (count_is("cells_gap", count, 4) < 0 || numbers_in(a, 2, args[1], "xy") < 0 ||
        numbers_in(b, 2, args[3], "other_xy") < 0 || points_open(&one, args[0], "cells") < 0)
        return NULL;
    if (points_open(&other, args[2], "other_cells") < 0) {
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
