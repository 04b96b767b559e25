/* A depth image: what is known of it, which surfaces it has, and how far away the one is that a box
 * is drawn round. */
#include "objects_view.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whether a surface goes on to a pixel from those beside it. */
static inline uint8_t goes_on(float here, float left, float above, float high,
                              const SegmentRules *rules)
{
    const float edge = (float)rules->edge_m, share = (float)rules->edge_share * here;
    const float limit = share > edge ? share : edge;
    return (here > 0.0f) & (high > (float)rules->floor_m) & (fabsf(here - left) <= limit) &
           (fabsf(here - above) <= limit);
}

/* Known depth, what may be of a thing, and where surfaces go on from pixel to pixel. */
static void look(View *view, const Grid *depth_m, Py_ssize_t stride, uint8_t *inside)
{
    const SegmentRules rules = *view->rules;
    const double camera = view->place.camera_z;
    const Py_ssize_t cols = view->surfaces.cols, half = stride / 2;
    for (Py_ssize_t row = 0; row < view->surfaces.rows; row++) {
        const float *from = GRID_ROW(*depth_m, float, half + row * stride) + half;
        const float *up = GRID_ROW(view->up, float, row);
        float *restrict depth = view->depth + row * cols;
        float *restrict standing = view->standing + row * cols;
        uint8_t *restrict on = inside + row * cols;
        for (Py_ssize_t col = 0; col < cols; col++)
            depth[col] = isfinite(from[col * stride]) ? from[col * stride] : 0.0f;
        for (Py_ssize_t col = 0; col < cols; col++) {
            const double high = (double)up[col] * (double)depth[col] + camera;
            const int thing = (depth[col] > 0.0f) & (high > rules.floor_m) &
                              (high < rules.ceiling_m);
            standing[col] = thing ? depth[col] : -INFINITY;
        }
        const float *above = row ? depth - cols : depth;
        if (cols)
            on[0] = goes_on(depth[0], depth[0], above[0], depth[0] * up[0] + (float)camera, &rules);
        for (Py_ssize_t col = 1; col < cols; col++)
            on[col] = goes_on(depth[col], depth[col - 1], above[col],
                              depth[col] * up[col] + (float)camera, &rules);
    }
}

const char *view_open(View *view, const Grid *depth_m, Py_ssize_t stride)
{
    const Py_ssize_t rows = view->forward.rows, cols = view->forward.cols, half = stride / 2;
    const size_t n = (size_t)rows * (size_t)cols;
    if (view->left.rows != rows || view->left.cols != cols || view->up.rows != rows ||
        view->up.cols != cols || (depth_m->rows - half + stride - 1) / stride != rows ||
        (depth_m->cols - half + stride - 1) / stride != cols)
        return "a depth image that its rays are not of";
    if (!are_few(rows + 1, cols + 1))
        return TOO_MANY_CELLS;
    view->memory = malloc((n + 1) * (5 * sizeof(double) + 2 * sizeof(Region) +
                                     3 * sizeof(int32_t) + 2 * sizeof(float) + 1));
    if (!view->memory)
        return NO_MEMORY;
    view->numbers = view->memory;
    view->surfaces = (Surfaces){.rows = rows, .cols = cols};
    view->surfaces.regions = (Region *)(void *)(view->numbers + 5 * (n + 1));
    view->within = view->surfaces.regions + n + 1;
    view->surfaces.label = (int32_t *)(void *)(view->within + n + 1);
    view->touched = view->surfaces.label + n + 1;
    view->wanted = view->touched + n + 1;
    view->depth = (float *)(void *)(view->wanted + n + 1);
    view->standing = view->depth + n + 1;
    uint8_t *inside = (uint8_t *)(view->standing + n + 1);
    look(view, depth_m, stride, inside);
    label_surfaces(&view->surfaces, inside, view->touched);
    memset(view->within, 0, (size_t)view->surfaces.labels * sizeof *view->within);
    memset(view->wanted, 0, (size_t)view->surfaces.labels * sizeof *view->wanted);
    return NULL;
}

/* Of n depths, in single precision as they are. */
static float quantile(const double *values, size_t n, double share, double *scratch)
{
    const double at = (double)(n - 1) * share;
    const size_t low = (size_t)at, ranks[2] = {low, low + 1 < n ? low + 1 : n - 1};
    double found[2];
    at_ranks(values, n, ranks, 2, found, scratch);
    const float below = (float)found[0], above = (float)found[1];
    const float part = (float)(at - (double)low), step = above - below;
    return part >= 0.5f ? above - step * (1.0f - part) : below + step * part;
}

static Box core_of(Box box, double share)
{
    const Py_ssize_t dy = (Py_ssize_t)((double)(box.bottom - box.top) * (1.0 - share) / 2.0);
    const Py_ssize_t dx = (Py_ssize_t)((double)(box.right - box.left) * (1.0 - share) / 2.0);
    return (Box){box.top + dy, box.bottom - dy, box.left + dx, box.right - dx};
}

/* Of known depths in a box, of one label or of all (-1): how many, and their quantile. */
static size_t depths_in(const View *view, Box box, int32_t label, float *found)
{
    const Py_ssize_t cols = view->surfaces.cols;
    double *values = view->numbers;
    size_t n = 0;
    for (Py_ssize_t row = box.top; row < box.bottom; row++) {
        const float *depth = view->depth + row * cols;
        const int32_t *labels = view->surfaces.label + row * cols;
        for (Py_ssize_t col = box.left; col < box.right; col++) {
            values[n] = (double)depth[col];
            n += label < 0 ? depth[col] > 0.0f : labels[col] == label;
        }
    }
    if (n)
        *found = quantile(values, n, view->rules->quantile, values + n);
    return n;
}

/* The commonest label as far away as that, of equals the lowest; 0 where there is none. */
static int32_t commonest(const View *view, Box box, float near_m)
{
    const float edge = (float)view->rules->edge_m;
    size_t touched = 0;
    int32_t best = 0;
    for (Py_ssize_t row = box.top; row < box.bottom; row++) {
        const float *depth = view->depth + row * view->surfaces.cols;
        const int32_t *labels = view->surfaces.label + row * view->surfaces.cols;
        for (Py_ssize_t col = box.left; col < box.right; col++) {
            const int32_t label = labels[col];
            if (!label || !(fabsf(depth[col] - near_m) <= edge))
                continue;
            if (!view->within[label].pixels++)
                view->touched[touched++] = label;
        }
    }
    for (size_t n = 0; n < touched; n++) {
        const int32_t label = view->touched[n];
        const int32_t more = view->within[label].pixels - view->within[best].pixels;
        best = more > 0 || (more == 0 && label < best) ? label : best;
    }
    for (size_t n = 0; n < touched; n++)
        view->within[view->touched[n]].pixels = 0;
    return best;
}

/* Notes the region of each label in the box; how many labels it has. */
static size_t note_regions(View *view, Box box)
{
    size_t touched = 0;
    for (Py_ssize_t row = box.top; row < box.bottom; row++) {
        const int32_t *labels = view->surfaces.label + row * view->surfaces.cols;
        for (Py_ssize_t col = box.left; col < box.right;) {
            const int32_t label = labels[col];
            const Py_ssize_t from = col;
            while (col < box.right && labels[col] == label)
                col++;
            if (!label)
                continue;
            if (!view->within[label].pixels)
                view->touched[touched++] = label;
            add_run(view->within + label, row, from, col);
        }
    }
    return touched;
}

/* Of the labels that do not go on beyond the box the one that spans most of it, if that is enough;
 * 0 where there is none, and where `own`, the nearest, is one of them. */
static int32_t spanning(View *view, Box box, int32_t own)
{
    const SegmentRules *rules = view->rules;
    const size_t touched = note_regions(view, box);
    double largest = rules->span_share *
                     (double)((box.bottom - box.top) * (box.right - box.left));
    int32_t found = 0, within = 0;
    for (size_t n = 0; n < touched; n++) {
        const int32_t label = view->touched[n];
        const Region *here = view->within + label, *whole = view->surfaces.regions + label;
        if (!(here->pixels >= rules->within_share * whole->pixels))
            continue;
        const double span = span_of(here);
        if (span > largest || (span == largest && label > found)) {
            largest = span;
            found = label;
        }
        within |= label == own;
    }
    for (size_t n = 0; n < touched; n++)
        view->within[view->touched[n]].pixels = 0;
    return within ? 0 : found;
}

/* Whether so much of a box has a depth that what is known there may be the thing, and not what
 * stands before one that is too far away. */
static int is_known(const View *view, Box box)
{
    Py_ssize_t known = 0;
    for (Py_ssize_t row = box.top; row < box.bottom; row++)
        for (Py_ssize_t col = box.left; col < box.right; col++)
            known += view->depth[row * view->surfaces.cols + col] > 0.0f;
    const double pixels = (double)((box.bottom - box.top) * (box.right - box.left));
    return (double)known >= view->rules->known_share * pixels;
}

float distance(View *view, Box box)
{
    if (!is_known(view, box))
        return 0.0f;
    const Box core = core_of(box, view->rules->core_share);
    float nearest_m, found_m;
    if (!depths_in(view, core, -1, &nearest_m))
        return 0.0f;
    const int32_t nearest = commonest(view, box, nearest_m);
    if (!nearest)
        return nearest_m;
    const int32_t other = spanning(view, box, nearest);
    if (other && (depths_in(view, core, other, &found_m) || depths_in(view, box, other, &found_m)))
        return found_m;
    return nearest_m;
}
