/* What one depth image shows of the floor plan: for each azimuth the nearest obstacle, the farthest
 * floor, where it drops and the nearest hole of the image, for each cell how many points of either.
 * See runtime/core/mapping/grid.py. */
#include "sampled.h"
#include "windows.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a pixel shows; of a cell FLOOR is a bit, the others count obstacles and drops. HOLE is where
 * floor would be near enough to be seen, and depth is unknown. DROP is what lies below the floor,
 * seen where its ray crosses the floor's plane: no floor is there. LOW, beside FLOOR or alone, is
 * what lies less below: a drop, too, if it is seen behind one, as its far side is. */
enum { NOTHING = 0, OBSTACLE = 1, HOLE = 2, LOW = 4, DROP = 0x10, FLOOR = 0x80, OBSTACLES = 0x0F,
       DROPS = 0x70 };

enum { MOST_SIDE = 1 << 24 }; /* of a grid, whose cells single precision numbers */

/* Both in the order in which Python gives them. */
typedef union {
    Grid all[9];
    struct {
        Grid evidence, drops, depth, forward, left, up, reach, groups, range;
    };
} Arrays;

typedef union {
    double all[20];
    struct {
        double stride, max_depth_m, camera_m, floor_m, height_m; /* heights above the floor */
        double cosine, sine, x_m, y_m, per_m; /* of the camera's yaw, its place in the grid; 1/m */
        double slack, lip_m, drop_within_m; /* see DepthView */
        double hits_needed, hit, miss, most, drop_most, cells_around;
        double hole_pixels; /* one above the other, of unknown depth, that may hide something */
    };
} Numbers;

typedef struct {
    Box box; /* of the grid: as far as the camera sees */
    uint8_t *seen;
    float *near_m, *far_m, *hole_m; /* by azimuth */
    float *edge_m, *open_m; /* by azimuth: the floor before the first drop; how near that drop is */
    int32_t *drops;         /* by azimuth, points so far */
    int32_t *holes;         /* by column, one above the other so far */
    int32_t *cell;         /* of the pixels of a row: in the box */
    uint8_t *what;
    float *distance;
} View;

/* One row of pixels: what each shows, how far, and of which cell. */
static void project(const Arrays *arrays, const Numbers *n, const View *view, Py_ssize_t row)
{
    const Py_ssize_t stride = (Py_ssize_t)n->stride, width = view->box.right - view->box.left;
    const float *restrict depth = sampled_row(&arrays->depth, stride, row);
    const float *restrict forward = GRID_ROW(arrays->forward, float, row);
    const float *restrict left = GRID_ROW(arrays->left, float, row);
    const float *restrict up = GRID_ROW(arrays->up, float, row);
    const float *restrict reach = GRID_ROW(arrays->reach, float, row);
    const float max_depth = (float)n->max_depth_m, camera = (float)n->camera_m;
    const float floor_m = (float)n->floor_m, height_m = (float)n->height_m;
    const float slack = (float)n->slack, lip_m = (float)n->lip_m;
    const float c = (float)n->cosine, s = (float)n->sine, per_m = (float)n->per_m;
    const float x = (float)n->x_m, y = (float)n->y_m;
    const float top = (float)view->box.top, low = (float)view->box.left;
    const float bottom = (float)(view->box.bottom - 1), high = (float)(view->box.right - 1);
    for (Py_ssize_t i = 0; i < arrays->up.cols; i++) {
        const float read = depth[i * stride];
        const int valid = (read > 0.0f) & (read <= max_depth);
        const float d = valid ? read : 0.0f;
        const float height = d * up[i] + camera;
        const int obstacle = valid & (height >= floor_m) & (height <= height_m);
        const int floor = valid & (fabsf(height) < floor_m);
        const int hole = !valid & (max_depth * up[i] + camera <= 0.0f);
        const int drop = valid & (height < -(floor_m + slack * (d * reach[i])));
        const int lower = valid & (height < -lip_m) & !drop;
        const float ahead = d * forward[i], aside = d * left[i];
        float col = ((c * ahead - s * aside) + x) * per_m;
        float line = ((s * ahead + c * aside) + y) * per_m;
        col = col > low ? col : low; /* what is outside of the grid counts at its rim */
        line = line > top ? line : top;
        col = col < high ? col : high;
        line = line < bottom ? line : bottom;
        view->distance[i] = d * reach[i];
        view->cell[i] =
            ((int32_t)line - (int32_t)top) * (int32_t)width + (int32_t)col - (int32_t)low;
        view->what[i] = (uint8_t)(obstacle * OBSTACLE + floor * FLOOR + hole * HOLE + drop * DROP +
                                  lower * LOW);
    }
}

/* What may stand where the lowest pixel of some above each other is a hole: as near as the floor
 * that the pixel below it would show. */
static float hole_from(const Arrays *arrays, const Numbers *n, Py_ssize_t row, Py_ssize_t col)
{
    const Py_ssize_t below = row + 1 < arrays->up.rows ? row + 1 : row;
    const float up = GRID_ROW(arrays->up, float, below)[col];
    return (float)n->camera_m / -up * GRID_ROW(arrays->reach, float, below)[col];
}

static int32_t group_of(const Arrays *arrays, Py_ssize_t row, Py_ssize_t col)
{
    return GRID_ROW(arrays->groups, int32_t, arrays->groups.rows == 1 ? 0 : row)[col];
}

/* A pixel of unknown depth; those below it, as many as `holes` tells, were as well. */
static void book_hole(const Arrays *arrays, const Numbers *n, const View *view, Py_ssize_t row,
                      Py_ssize_t col)
{
    const int32_t so_far = ++view->holes[col], needed = (int32_t)n->hole_pixels;
    if (so_far < needed)
        return;
    for (Py_ssize_t from = so_far == needed ? row + needed - 1 : row; from >= row; from--) {
        float *hole = &view->hole_m[group_of(arrays, from, col)];
        const float distance = hole_from(arrays, n, from, col);
        if (distance >= 0.0f && distance < *hole)
            *hole = distance;
    }
}

/* A cell of the box by forward and left m from the camera; as `project` tells it. */
static uint8_t *seen_at(const Numbers *n, const View *view, float ahead, float aside)
{
    const float c = (float)n->cosine, s = (float)n->sine, per_m = (float)n->per_m;
    const float col = ((c * ahead - s * aside) + (float)n->x_m) * per_m;
    const float line = ((s * ahead + c * aside) + (float)n->y_m) * per_m;
    const Box *box = &view->box;
    const float low = (float)box->left, high = (float)(box->right - 1);
    const float top = (float)box->top, bottom = (float)(box->bottom - 1);
    const Py_ssize_t x = (Py_ssize_t)(col > low ? (col < high ? col : high) : low);
    const Py_ssize_t y = (Py_ssize_t)(line > top ? (line < bottom ? line : bottom) : top);
    return &view->seen[(y - box->top) * (box->right - box->left) + x - box->left];
}

/* A point below the floor, unless an obstacle stands before it. Of an azimuth the last of as many as
 * are needed tells where the floor ends: what lies between the last floor and it is unseen. */
static void book_drop(const Arrays *arrays, const Numbers *n, const View *view, Py_ssize_t row,
                      Py_ssize_t col)
{
    const int32_t needed = (int32_t)n->hits_needed, group = group_of(arrays, row, col);
    const float depth = (float)n->camera_m / -GRID_ROW(arrays->up, float, row)[col];
    const float distance = depth * GRID_ROW(arrays->reach, float, row)[col];
    if (!(distance >= 0.0f && distance <= view->near_m[group]))
        return;
    if (view->drops[group] < needed) {
        view->edge_m[group] = view->far_m[group];
        view->open_m[group] = distance;
        view->drops[group]++;
    }
    if (distance > (float)n->drop_within_m)
        return;
    uint8_t *seen = seen_at(n, view, depth * GRID_ROW(arrays->forward, float, row)[col],
                            depth * GRID_ROW(arrays->left, float, row)[col]);
    *seen = (uint8_t)(*seen + ((*seen & DROPS) < needed * DROP) * DROP);
}

/* Whether floor drops at an azimuth; of the points of three, as one alone may have few: pixels of a
 * tilted camera lie between azimuths. */
static int drops_at(const View *view, Py_ssize_t k, Py_ssize_t count, const Numbers *n)
{
    int32_t points = view->drops[k];
    points += k > 0 ? view->drops[k - 1] : 0;
    points += k + 1 < count ? view->drops[k + 1] : 0;
    return points >= (int32_t)n->hits_needed;
}

static void book(const Arrays *arrays, const Numbers *n, const View *view, Py_ssize_t row)
{
    const uint8_t hits_needed = (uint8_t)n->hits_needed;
    const int32_t *group =
        GRID_ROW(arrays->groups, int32_t, arrays->groups.rows == 1 ? 0 : row);
    for (Py_ssize_t i = 0; i < arrays->up.cols; i++) {
        const uint8_t what = view->what[i];
        if (what == HOLE) {
            book_hole(arrays, n, view, row, i);
            continue;
        }
        view->holes[i] = 0;
        if (what == DROP || ((what & LOW) && drops_at(view, group[i], arrays->range.cols, n))) {
            book_drop(arrays, n, view, row, i);
            continue;
        }
        const float distance = view->distance[i];
        uint8_t *seen = &view->seen[view->cell[i]];
        if (what == OBSTACLE) {
            *seen = (uint8_t)(*seen + ((*seen & OBSTACLES) < hits_needed));
            if (distance < view->near_m[group[i]])
                view->near_m[group[i]] = distance;
        } else if (what & FLOOR) {
            *seen |= FLOOR;
            if (distance > view->far_m[group[i]])
                view->far_m[group[i]] = distance;
        }
    }
}

/* Evidence that a cell has no floor: seen to drop, and no floor in it; only floor undoes it. */
static int sunk(int before, uint8_t seen, const Numbers *n)
{
    if ((seen & DROPS) >= (int)n->hits_needed * DROP && !(seen & FLOOR))
        return before < (int)n->drop_most ? before + 1 : before;
    return seen == FLOOR && before > 0 ? before - 1 : before;
}

/* Books evidence for what was seen, and finds the window of the cells of which something was, and
 * that of those which drop. */
static Box weigh(Grid *evidence, Grid *drops, const View *view, const Numbers *n, Box *dropped)
{
    Box found = NO_BOX;
    const int needed = (int)n->hits_needed, hit = (int)n->hit, miss = (int)n->miss;
    const int most = (int)n->most;
    const Py_ssize_t width = view->box.right - view->box.left;
    for (Py_ssize_t row = view->box.top; row < view->box.bottom; row++) {
        const uint8_t *seen = view->seen + (row - view->box.top) * width;
        int16_t *cell = GRID_ROW(*evidence, int16_t, row) + view->box.left;
        uint8_t *drop = GRID_ROW(*drops, uint8_t, row) + view->box.left;
        Py_ssize_t first, end;
        if (!bytes_span(seen, width, &first, &end))
            continue;
        box_join_row(&found, row, view->box.left + first, view->box.left + end);
        for (Py_ssize_t i = first; i < end; i++) {
            int now = cell[i];
            if ((seen[i] & OBSTACLES) >= needed)
                now = now + hit < most ? now + hit : most;
            else if (seen[i] == FLOOR)
                now = now - miss > -most ? now - miss : -most;
            cell[i] = (int16_t)now;
            if (!drop[i] && !(seen[i] & DROPS))
                continue;
            drop[i] = (uint8_t)sunk(drop[i], seen[i], n);
            if (seen[i] & DROPS)
                box_join_row(dropped, row, view->box.left + i, view->box.left + i + 1);
        }
    }
    return found;
}

/* As much of the grid as the camera sees; at least the cell of its rim that is nearest. */
static Box around(const Grid *grid, const Numbers *n)
{
    const double ends[4] = {
        floor(n->y_m * n->per_m) - n->cells_around, floor(n->y_m * n->per_m) + n->cells_around,
        floor(n->x_m * n->per_m) - n->cells_around, floor(n->x_m * n->per_m) + n->cells_around};
    Py_ssize_t held[4];
    for (int k = 0; k < 4; k++) {
        const double most = (double)((k < 2 ? grid->rows : grid->cols) - 1);
        held[k] = (Py_ssize_t)(ends[k] > 0.0 ? (ends[k] < most ? ends[k] : most) : 0.0);
    }
    return (Box){held[0], held[1] + 1, held[2], held[3] + 1};
}

/* Where the floor ends at an azimuth, INFINITY for nowhere, and how near the drop is there. */
static float edge_of(const View *view, Py_ssize_t k, Py_ssize_t count, const Numbers *n,
                     float *drop_m)
{
    const Py_ssize_t first = k > 0 ? k - 1 : 0, end = k + 2 < count ? k + 2 : count;
    float edge = 0.0f;
    *drop_m = 0.0f;
    for (Py_ssize_t i = first; i < end; i++) {
        if (!view->drops[i])
            continue;
        edge = view->edge_m[i] > edge ? view->edge_m[i] : edge;
        *drop_m = view->open_m[i] > *drop_m ? view->open_m[i] : *drop_m;
    }
    return drops_at(view, k, count, n) ? edge : INFINITY;
}

/* By azimuth: the free range, how far of that floor was seen, and where floor drops of which none
 * was seen before, 0 for nowhere. */
static void outline(Grid *range, const View *view, const Numbers *n)
{
    float *free_m = GRID_ROW(*range, float, 0), *floor_m = GRID_ROW(*range, float, 1);
    float *open_m = GRID_ROW(*range, float, 2), drop_m;
    for (Py_ssize_t k = 0; k < range->cols; k++) {
        const float edge = edge_of(view, k, range->cols, n, &drop_m);
        float seen = view->near_m[k] < INFINITY ? view->near_m[k] : view->far_m[k];
        seen = edge < seen ? edge : seen;
        free_m[k] = seen < view->hole_m[k] ? seen : view->hole_m[k];
        floor_m[k] = view->far_m[k] < free_m[k] ? view->far_m[k] : free_m[k];
        open_m[k] = edge <= 0.0f ? drop_m : 0.0f;
    }
}

static int integrate(Arrays *arrays, const Numbers *n, Box *changed, Box *dropped)
{
    const Py_ssize_t pixels = arrays->up.cols, azimuths = arrays->range.cols;
    View view = {.box = around(&arrays->evidence, n)};
    const size_t cells = (size_t)((view.box.bottom - view.box.top) *
                                  (view.box.right - view.box.left));
    view.seen = calloc(cells, 1);
    view.near_m = malloc((size_t)(5 * azimuths + pixels) * sizeof(float));
    view.drops = calloc((size_t)azimuths, sizeof *view.drops);
    view.cell = calloc((size_t)pixels, 2 * sizeof *view.cell + 1);
    const int ready = view.seen && view.near_m && view.drops && view.cell;
    if (ready) {
        view.far_m = view.near_m + azimuths;
        view.hole_m = view.far_m + azimuths;
        view.edge_m = view.hole_m + azimuths;
        view.open_m = view.edge_m + azimuths;
        view.distance = view.open_m + azimuths;
        view.holes = view.cell + pixels;
        view.what = (uint8_t *)(view.holes + pixels);
        for (Py_ssize_t k = 0; k < azimuths; k++) {
            view.near_m[k] = view.hole_m[k] = INFINITY;
            view.far_m[k] = view.edge_m[k] = view.open_m[k] = 0.0f;
        }
        for (Py_ssize_t row = arrays->up.rows - 1; row >= 0; row--) {
            project(arrays, n, &view, row);
            book(arrays, n, &view, row);
        }
        *changed = weigh(&arrays->evidence, &arrays->drops, &view, n, dropped);
        outline(&arrays->range, &view, n);
    }
    free(view.seen);
    free(view.near_m);
    free(view.drops);
    free(view.cell);
    return ready ? 0 : -1;
}

static int in_range(const Grid *groups, Py_ssize_t count)
{
    for (Py_ssize_t row = 0; row < groups->rows; row++) {
        const int32_t *group = GRID_ROW(*groups, int32_t, row);
        for (Py_ssize_t col = 0; col < groups->cols; col++)
            if (group[col] < 0 || group[col] >= count)
                return 0;
    }
    return 1;
}

static const char *problem_of(const Arrays *a, const Numbers *n)
{
    const char *problem = sampling_problem(&a->depth, &a->up, n->stride);
    if (problem)
        return problem;
    if (a->groups.cols != a->up.cols || (a->groups.rows != 1 && a->groups.rows != a->up.rows) ||
        a->range.rows != 3 || !in_range(&a->groups, a->range.cols))
        return "groups: not one of the azimuths for each pixel, or for each column";
    if (!(n->hole_pixels >= 1.0 && n->hole_pixels < 1e6))
        return "hole_pixels: no number of pixels";
    if (a->evidence.rows > MOST_SIDE || a->evidence.cols > MOST_SIDE)
        return TOO_MANY_CELLS;
    if (!(n->cells_around >= 0.0 && n->cells_around < 16384.0) || !a->evidence.rows ||
        !a->evidence.cols)
        return "cells_around: more than any camera sees, or no cell";
    if (!(n->hits_needed >= 1.0 && n->hits_needed * DROP <= DROPS) ||
        !(n->most >= 0.0 && n->most <= INT16_MAX) ||
        !(n->drop_most >= 0.0 && n->drop_most <= UINT8_MAX) || !(fabs(n->hit) + fabs(n->miss) < 1e6))
        return "evidence: more than its cells can hold";
    return NULL;
}

PyObject *kernel_integrate(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'h', 1, "evidence"}, {'B', 1, "drops"},
                                     {'f', 0, "depth_m"},  {'f', 0, "forward"},
                                     {'f', 0, "left"},     {'f', 0, "up"},
                                     {'f', 0, "reach"},    {'i', 0, "groups"},
                                     {'f', 1, "range_m"}};
    enum { ARRAYS = 9, NUMBERS = 20 };
    Arrays arrays;
    Numbers numbers;
    Box changed = NO_BOX, dropped = NO_BOX;
    if (count_is("integrate", count, ARRAYS + NUMBERS) < 0 ||
        numbers_of(numbers.all, args + ARRAYS, NUMBERS) < 0 ||
        grids_open(arrays.all, args, specs, ARRAYS) < 0)
        return NULL;
    const int both = grids_alike(arrays.all, specs, 2);
    const int alike = both < 0 ? both : grids_alike(arrays.all + 3, specs + 3, 4);
    const char *problem = alike < 0 ? NULL : problem_of(&arrays, &numbers);
    int done = 0;
    if (alike == 0 && !problem) {
        Py_BEGIN_ALLOW_THREADS
        done = integrate(&arrays, &numbers, &changed, &dropped);
        Py_END_ALLOW_THREADS
    }
    grids_close(arrays.all, ARRAYS);
    if (problem)
        return failed("integrate", problem);
    if (done < 0)
        return PyErr_NoMemory();
    return alike < 0 ? NULL
                     : Py_BuildValue("NN", box_as_tuple(&changed), box_as_tuple(&dropped));
}
