/* What one depth image shows of the floor plan: for each azimuth the nearest obstacle, the farthest
 * floor and the nearest hole, for each cell how many points of either. See
 * runtime/core/mapping/grid.py. */
#include "windows.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a pixel shows; of a cell FLOOR is a bit, the others count obstacles. HOLE is where floor
 * would be near enough to be seen, and depth is unknown. */
enum { NOTHING = 0, OBSTACLE = 1, HOLE = 2, FLOOR = 0x80, OBSTACLES = 0x7F };

enum { MOST_SIDE = 1 << 24 }; /* of a grid, whose cells single precision numbers */

/* Both in the order in which Python gives them. */
typedef union {
    Grid all[8];
    struct {
        Grid evidence, depth, forward, left, up, reach, groups, range;
    };
} Arrays;

typedef union {
    double all[16];
    struct {
        double stride, max_depth_m, camera_m, floor_m, height_m; /* heights above the floor */
        double cosine, sine, x_m, y_m, per_m; /* of the camera's yaw, its place in the grid; 1/m */
        double hits_needed, hit, miss, most, cells_around;
        double hole_pixels; /* one above the other, of unknown depth, that may hide something */
    };
} Numbers;

typedef struct {
    Box box; /* of the grid: as far as the camera sees */
    uint8_t *seen;
    float *near_m, *far_m, *hole_m; /* by azimuth */
    int32_t *holes;                 /* by column, one above the other so far */
    int32_t *cell;         /* of the pixels of a row: in the box */
    uint8_t *what;
    float *distance;
} View;

/* One row of pixels: what each shows, how far, and of which cell. */
static void project(const Arrays *arrays, const Numbers *n, const View *view, Py_ssize_t row)
{
    const Py_ssize_t stride = (Py_ssize_t)n->stride, width = view->box.right - view->box.left;
    const float *restrict depth =
        GRID_ROW(arrays->depth, float, stride / 2 + row * stride) + stride / 2;
    const float *restrict forward = GRID_ROW(arrays->forward, float, row);
    const float *restrict left = GRID_ROW(arrays->left, float, row);
    const float *restrict up = GRID_ROW(arrays->up, float, row);
    const float *restrict reach = GRID_ROW(arrays->reach, float, row);
    const float max_depth = (float)n->max_depth_m, camera = (float)n->camera_m;
    const float floor_m = (float)n->floor_m, height_m = (float)n->height_m;
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
        view->what[i] = (uint8_t)(obstacle * OBSTACLE + floor * FLOOR + hole * HOLE);
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
        const float distance = view->distance[i];
        uint8_t *seen = &view->seen[view->cell[i]];
        if (what == OBSTACLE) {
            *seen = (uint8_t)(*seen + ((*seen & OBSTACLES) < hits_needed));
            if (distance < view->near_m[group[i]])
                view->near_m[group[i]] = distance;
        } else if (what == FLOOR) {
            *seen |= FLOOR;
            if (distance > view->far_m[group[i]])
                view->far_m[group[i]] = distance;
        }
    }
}

/* Books evidence for what was seen, and finds the window of the cells of which something was. */
static Box weigh(Grid *evidence, const View *view, const Numbers *n)
{
    Box found = NO_BOX;
    const int needed = (int)n->hits_needed, hit = (int)n->hit, miss = (int)n->miss;
    const int most = (int)n->most;
    const Py_ssize_t width = view->box.right - view->box.left;
    for (Py_ssize_t row = view->box.top; row < view->box.bottom; row++) {
        const uint8_t *seen = view->seen + (row - view->box.top) * width;
        int16_t *cell = GRID_ROW(*evidence, int16_t, row) + view->box.left;
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

static void outline(Grid *range, const View *view)
{
    float *out = GRID_ROW(*range, float, 0);
    for (Py_ssize_t n = 0; n < range->cols; n++) {
        const float seen = view->near_m[n] < INFINITY ? view->near_m[n] : view->far_m[n];
        out[n] = seen < view->hole_m[n] ? seen : view->hole_m[n];
    }
}

static int integrate(Arrays *arrays, const Numbers *n, Box *changed)
{
    const Py_ssize_t pixels = arrays->up.cols, azimuths = arrays->range.cols;
    View view = {.box = around(&arrays->evidence, n)};
    const size_t cells = (size_t)((view.box.bottom - view.box.top) *
                                  (view.box.right - view.box.left));
    view.seen = calloc(cells, 1);
    view.near_m = malloc((size_t)(3 * azimuths + pixels) * sizeof(float));
    view.cell = calloc((size_t)pixels, 2 * sizeof *view.cell + 1);
    const int ready = view.seen && view.near_m && view.cell;
    if (ready) {
        view.far_m = view.near_m + azimuths;
        view.hole_m = view.far_m + azimuths;
        view.distance = view.hole_m + azimuths;
        view.holes = view.cell + pixels;
        view.what = (uint8_t *)(view.holes + pixels);
        for (Py_ssize_t k = 0; k < azimuths; k++) {
            view.near_m[k] = view.hole_m[k] = INFINITY;
            view.far_m[k] = 0.0f;
        }
        for (Py_ssize_t row = arrays->up.rows - 1; row >= 0; row--) {
            project(arrays, n, &view, row);
            book(arrays, n, &view, row);
        }
        *changed = weigh(&arrays->evidence, &view, n);
        outline(&arrays->range, &view);
    }
    free(view.seen);
    free(view.near_m);
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
    const Py_ssize_t stride = n->stride >= 1.0 && n->stride < 1e6 ? (Py_ssize_t)n->stride : 0;
    if (!stride)
        return "stride: less than a pixel";
    if ((a->depth.rows - stride / 2 + stride - 1) / stride != a->up.rows ||
        (a->depth.cols - stride / 2 + stride - 1) / stride != a->up.cols)
        return "depth_m: another image than that of the rays";
    if (a->groups.cols != a->up.cols || (a->groups.rows != 1 && a->groups.rows != a->up.rows) ||
        a->range.rows != 1 || !in_range(&a->groups, a->range.cols))
        return "groups: not one of the azimuths for each pixel, or for each column";
    if (!(n->hole_pixels >= 1.0 && n->hole_pixels < 1e6))
        return "hole_pixels: no number of pixels";
    if (a->evidence.rows > MOST_SIDE || a->evidence.cols > MOST_SIDE)
        return TOO_MANY_CELLS;
    if (!(n->cells_around >= 0.0 && n->cells_around < 16384.0) || !a->evidence.rows ||
        !a->evidence.cols)
        return "cells_around: more than any camera sees, or no cell";
    if (!(n->hits_needed >= 1.0 && n->hits_needed < OBSTACLES) ||
        !(n->most >= 0.0 && n->most <= INT16_MAX) || !(fabs(n->hit) + fabs(n->miss) < 1e6))
        return "evidence: more than its cells can hold";
    return NULL;
}

PyObject *kernel_integrate(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'h', 1, "evidence"}, {'f', 0, "depth_m"},
                                     {'f', 0, "forward"},  {'f', 0, "left"},
                                     {'f', 0, "up"},       {'f', 0, "reach"},
                                     {'i', 0, "groups"},   {'f', 1, "range_m"}};
    enum { ARRAYS = 8, NUMBERS = 16 };
    Arrays arrays;
    Numbers numbers;
    Box changed = NO_BOX;
    if (count_is("integrate", count, ARRAYS + NUMBERS) < 0 ||
        numbers_of(numbers.all, args + ARRAYS, NUMBERS) < 0 ||
        grids_open(arrays.all, args, specs, ARRAYS) < 0)
        return NULL;
    const int alike = grids_alike(arrays.all + 2, specs + 2, 4);
    const char *problem = alike < 0 ? NULL : problem_of(&arrays, &numbers);
    int done = 0;
    if (alike == 0 && !problem) {
        Py_BEGIN_ALLOW_THREADS
        done = integrate(&arrays, &numbers, &changed);
        Py_END_ALLOW_THREADS
    }
    grids_close(arrays.all, ARRAYS);
    if (problem)
        return failed("integrate", problem);
    if (done < 0)
        return PyErr_NoMemory();
    return alike < 0 ? NULL : box_as_tuple(&changed);
}
