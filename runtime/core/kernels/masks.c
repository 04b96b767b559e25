/* Masks of the navigation map, within a window: occupied, free and unknown of the evidence, and the
 * boundary of what is free. See runtime/core/mapping/grid.py and frontiers.py. */
#include "windows.h"
#include <stdlib.h>
#include <string.h>

/* A part of a grid with so many cells of 0 around it that no neighbour need be asked for. */
typedef struct {
    uint8_t *at; /* the first cell */
    uint8_t *block;
    Py_ssize_t rows, cols, width;
} Patch;

static int patch_make(Patch *patch, const Box *box, Py_ssize_t padding)
{
    patch->rows = box->bottom - box->top;
    patch->cols = box->right - box->left;
    patch->width = patch->cols + 2 * padding;
    patch->block = calloc((size_t)(patch->width * (patch->rows + 2 * padding)) + 1, 1);
    patch->at = patch->block + padding * patch->width + padding;
    return patch->block ? 0 : -1;
}

#define PATCH_ROW(patch, row) ((patch)->at + (row) * (patch)->width)

static void join(uint8_t *restrict into, const uint8_t *from, Py_ssize_t n)
{
    for (Py_ssize_t i = 0; i < n; i++)
        into[i] |= from[i];
}

/* Marks the cells that have a marked one in the square of so many cells around them. */
static int dilate(Patch *patch, Py_ssize_t reach)
{
    const size_t cols = (size_t)patch->cols;
    uint8_t *kept = malloc((size_t)(reach + 1) * cols + 1);
    if (!kept)
        return -1;
    for (Py_ssize_t row = 0; row < patch->rows; row++) {
        uint8_t *line = PATCH_ROW(patch, row);
        memcpy(kept, line, cols);
        for (Py_ssize_t k = 1; k <= reach; k++) {
            join(kept, line - k, patch->cols);
            join(kept, line + k, patch->cols);
        }
        memcpy(line, kept, cols);
    }
    /* Downward; of the rows above those as they were are still asked for. */
    for (Py_ssize_t row = 0; row < patch->rows; row++) {
        uint8_t *line = PATCH_ROW(patch, row);
        memcpy(kept + (size_t)(row % (reach + 1)) * cols, line, cols);
        for (Py_ssize_t k = 1; k <= reach; k++) {
            if (row + k < patch->rows)
                join(line, PATCH_ROW(patch, row + k), patch->cols);
            if (row >= k)
                join(line, kept + (size_t)((row - k) % (reach + 1)) * cols, patch->cols);
        }
    }
    free(kept);
    return 0;
}

static void turn_over(Patch *patch)
{
    for (Py_ssize_t row = 0; row < patch->rows; row++) {
        uint8_t *line = PATCH_ROW(patch, row);
        for (Py_ssize_t i = 0; i < patch->cols; i++)
            line[i] ^= 1;
    }
}

enum { GAP = 2 }; /* obstacle cells less than 2 * GAP + 1 apart are one thing */

typedef union {
    Grid all[8];
    struct {
        Grid evidence, drops, bumped, swept, doubtful, occupied, free, unknown;
    };
} Masks;

/* From which evidence on a cell holds an obstacle, or has no floor. */
typedef struct {
    int occupied, drop;
} Bounds;

static void find_occupied(const Masks *masks, const Box *box, const Bounds *at, Patch *into)
{
    for (Py_ssize_t row = 0; row < into->rows; row++) {
        const int16_t *evidence = GRID_ROW(masks->evidence, int16_t, box->top + row) + box->left;
        const uint8_t *drops = GRID_ROW(masks->drops, uint8_t, box->top + row) + box->left;
        const uint8_t *bumped = GRID_ROW(masks->bumped, uint8_t, box->top + row) + box->left;
        uint8_t *line = PATCH_ROW(into, row);
        for (Py_ssize_t i = 0; i < into->cols; i++)
            line[i] = (uint8_t)((evidence[i] >= at->occupied) | (drops[i] >= at->drop) |
                                (bumped[i] != 0));
    }
}

/* One row of the masks; `closed` is the row of obstacles without their gaps. `line` tells
 * afterwards where the masks changed, and `known` where something is known. */
static void derive_row(const Masks *masks, Py_ssize_t row, const Box *box, const Bounds *at,
                       const uint8_t *closed, uint8_t *restrict line, uint8_t *restrict known)
{
    const int16_t *evidence = GRID_ROW(masks->evidence, int16_t, row) + box->left;
    const uint8_t *drops = GRID_ROW(masks->drops, uint8_t, row) + box->left;
    const uint8_t *bumped = GRID_ROW(masks->bumped, uint8_t, row) + box->left;
    const uint8_t *swept = GRID_ROW(masks->swept, uint8_t, row) + box->left;
    const uint8_t *doubtful = GRID_ROW(masks->doubtful, uint8_t, row) + box->left;
    uint8_t *restrict occupied = GRID_ROW(masks->occupied, uint8_t, row) + box->left;
    uint8_t *restrict open = GRID_ROW(masks->free, uint8_t, row) + box->left;
    uint8_t *restrict unknown = GRID_ROW(masks->unknown, uint8_t, row) + box->left;
    for (Py_ssize_t i = 0; i < box->right - box->left; i++) {
        const uint8_t full = (uint8_t)((evidence[i] >= at->occupied) | (drops[i] >= at->drop) |
                                       (bumped[i] != 0));
        const uint8_t passed = (uint8_t)((swept[i] != 0) & !closed[i] & !doubtful[i]);
        const uint8_t empty = (uint8_t)(((evidence[i] < 0) | passed) & !full);
        line[i] = (uint8_t)((occupied[i] ^ full) | (open[i] ^ empty));
        known[i] = full | empty;
        occupied[i] = full;
        open[i] = empty;
        unknown[i] = !(full | empty);
    }
}

static int derive(Masks *masks, const Box *window, const Bounds *at, Box *changed, Box *known)
{
    const Box source = box_widened(window, 2 * GAP, &masks->evidence);
    const Py_ssize_t down = window->top - source.top, right = window->left - source.left;
    const Py_ssize_t cols = window->right - window->left;
    Patch patch;
    uint8_t *lines = malloc((size_t)(2 * cols) + 1);
    int done = patch_make(&patch, &source, GAP);
    if (done == 0 && lines) {
        find_occupied(masks, &source, at, &patch);
        done = dilate(&patch, GAP);
        turn_over(&patch); /* shrunk again: what is not closed is wider by as much */
        done |= dilate(&patch, GAP);
        turn_over(&patch);
        for (Py_ssize_t row = window->top; row < window->bottom && done == 0; row++) {
            Py_ssize_t first, end;
            derive_row(masks, row, window, at,
                       PATCH_ROW(&patch, row - window->top + down) + right, lines, lines + cols);
            if (bytes_span(lines, cols, &first, &end))
                box_join_row(changed, row, window->left + first, window->left + end);
            if (bytes_span(lines + cols, cols, &first, &end))
                box_join_row(known, row, window->left + first, window->left + end);
        }
    }
    free(patch.block);
    const int failed = done < 0 || !lines;
    free(lines);
    return failed ? -1 : 0;
}

PyObject *kernel_derive(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'h', 0, "evidence"}, {'B', 0, "drops"}, {0, 0, "bumped"},
                                     {0, 0, "swept"},      {0, 0, "doubtful"}, {0, 1, "occupied"},
                                     {0, 1, "free"},       {0, 1, "unknown"}};
    Masks masks;
    Box window, changed = NO_BOX, known = NO_BOX;
    double numbers[2];
    int done = -1;
    if (count_is("derive", count, 14) < 0 || numbers_of(numbers, args + 8, 2) < 0)
        return NULL;
    if (!(numbers[0] > INT16_MIN && numbers[0] < INT16_MAX))
        return failed("derive", "occupied_at: more than evidence can be");
    if (!(numbers[1] >= 1.0 && numbers[1] <= UINT8_MAX))
        return failed("derive", "drop_at: more than evidence can be, or none");
    if (grids_open(masks.all, args, specs, 8) < 0)
        return NULL;
    if (grids_alike(masks.all, specs, 8) == 0 && box_of(&window, args + 10, &masks.evidence) == 0) {
        const Bounds at = {(int)numbers[0], (int)numbers[1]};
        Py_BEGIN_ALLOW_THREADS
        done = derive(&masks, &window, &at, &changed, &known);
        Py_END_ALLOW_THREADS
        if (done < 0)
            PyErr_NoMemory();
    }
    grids_close(masks.all, 8);
    return done < 0 ? NULL : Py_BuildValue("NN", box_as_tuple(&changed), box_as_tuple(&known));
}

typedef union {
    Grid all[5];
    struct {
        Grid edge, free, unknown, occupied, given_up;
    };
} Edges;

static int copied(Patch *patch, const Grid *mask, const Box *box, Py_ssize_t reach)
{
    if (patch_make(patch, box, reach) < 0)
        return -1;
    for (Py_ssize_t row = 0; row < patch->rows; row++) {
        const uint8_t *from = GRID_ROW(*mask, uint8_t, box->top + row) + box->left;
        memcpy(PATCH_ROW(patch, row), from, (size_t)patch->cols);
    }
    return dilate(patch, reach);
}

static int find_edge(Edges *e, const Box *window, Py_ssize_t wall_gap, Box *changed)
{
    const Py_ssize_t reach = wall_gap > 1 ? wall_gap : 1, cols = window->right - window->left;
    const Box source = box_widened(window, reach, &e->edge);
    const Py_ssize_t down = window->top - source.top, right = window->left - source.left;
    Patch unknown = {0}, walls = {0};
    uint8_t *line = malloc((size_t)cols + 1);
    int done = line ? copied(&unknown, &e->unknown, &source, 1) : -1;
    done = done == 0 ? copied(&walls, &e->occupied, &source, wall_gap) : -1;
    for (Py_ssize_t row = window->top; row < window->bottom && done == 0; row++) {
        const uint8_t *beside = PATCH_ROW(&unknown, row - window->top + down) + right;
        const uint8_t *wall = PATCH_ROW(&walls, row - window->top + down) + right;
        const uint8_t *open = GRID_ROW(e->free, uint8_t, row) + window->left;
        const uint8_t *given_up = GRID_ROW(e->given_up, uint8_t, row) + window->left;
        uint8_t *edge = GRID_ROW(e->edge, uint8_t, row) + window->left;
        Py_ssize_t first, end;
        for (Py_ssize_t i = 0; i < cols; i++) {
            const int borders = (open[i] != 0) & (beside[i] != 0);
            const uint8_t now = (uint8_t)(borders & !wall[i] & !given_up[i]);
            line[i] = edge[i] ^ now;
            edge[i] = now;
        }
        if (bytes_span(line, cols, &first, &end))
            box_join_row(changed, row, window->left + first, window->left + end);
    }
    free(line);
    free(unknown.block);
    free(walls.block);
    return done;
}

PyObject *kernel_boundary(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{0, 1, "edge"},     {0, 0, "free"},     {0, 0, "unknown"},
                                     {0, 0, "occupied"}, {0, 0, "given_up"}};
    Edges edges;
    Box window, changed = NO_BOX;
    double wall_gap;
    int done = -1;
    if (count_is("boundary", count, 10) < 0 || numbers_of(&wall_gap, args + 5, 1) < 0)
        return NULL;
    if (!(wall_gap >= 0.0 && wall_gap < 1024.0))
        return failed("boundary", "wall_gap: no number of cells");
    if (grids_open(edges.all, args, specs, 5) < 0)
        return NULL;
    if (grids_alike(edges.all, specs, 5) == 0 && box_of(&window, args + 6, &edges.edge) == 0) {
        Py_BEGIN_ALLOW_THREADS
        done = find_edge(&edges, &window, (Py_ssize_t)wall_gap, &changed);
        Py_END_ALLOW_THREADS
        if (done < 0)
            PyErr_NoMemory();
    }
    grids_close(edges.all, 5);
    return done < 0 ? NULL : box_as_tuple(&changed);
}
