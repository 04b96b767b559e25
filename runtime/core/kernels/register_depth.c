/* A depth image as another camera would have measured it: each pixel is put where it falls, the
 * nearest wins. See runtime/core/optics/registered.py. */
#include "arguments.h"
#include <math.h>

/* Both in the order in which Python gives them. */
typedef union {
    Grid all[4];
    struct {
        Grid seen, depth, across, down;
    };
} Arrays;

typedef union {
    double all[18];
    struct {
        double rows[3][4];                   /* from the first frame to the second */
        double fx, fy, cx, cy, wide, high; /* of the second camera */
    };
} Numbers;

/* A pixel is told a little wider than it is, so that a slanted surface has no cracks; and never as
 * wide as what is right before the lens would be. */
static const float WIDER = 1.25f, WIDEST = 8.0f, NEAREST_M = 0.02f;

typedef struct {
    int first, last;
} Span;

/* The pixels whose middles are within `wide` around a place in the image; a pixel that is smaller
 * than the target's still is somewhere. What is put there is not below 0, where a conversion to an
 * integer is what rounding down is. */
static inline Span span(float middle, float wide, int size)
{
    const float wider = wide * WIDER, half = 0.5f * (wider < WIDEST ? wider : WIDEST);
    const float low = middle - half + 0.5f, high = middle + half - 0.5f;
    Span found = {low > 0.0f ? (int)low : 0, high > 0.0f ? (int)high : 0};
    if (found.last >= size)
        found.last = size - 1;
    if (found.last < found.first || high < 0.0f)
        found.first = found.last = (int)middle;
    return found;
}

typedef struct {
    float fx, fy, cx, cy, wide, high;
} Camera;

static inline void put(const Grid *seen, const Camera *c, float x, float y, float z,
                       float source_m)
{
    const float per_m = 1.0f / z, larger = source_m * per_m;
    const float u = c->fx * x * per_m + c->cx, v = c->fy * y * per_m + c->cy;
    if (!(u >= 0.0f && u < (float)seen->cols && v >= 0.0f && v < (float)seen->rows))
        return;
    const Span across = span(u, c->wide * larger, (int)seen->cols);
    const Span down = span(v, c->high * larger, (int)seen->rows);
    for (int row = down.first; row <= down.last; row++) {
        float *pixels = GRID_ROW(*seen, float, row);
        for (int i = across.first; i <= across.last; i++)
            if (!(pixels[i] > 0.0f && pixels[i] <= z))
                pixels[i] = z;
    }
}

static void register_all(const Arrays *a, const Numbers *n)
{
    const Camera camera = {(float)n->fx, (float)n->fy,   (float)n->cx,
                           (float)n->cy, (float)n->wide, (float)n->high};
    float t[3][4];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            t[i][j] = (float)n->rows[i][j];
    for (Py_ssize_t row = 0; row < a->seen.rows; row++) {
        float *pixels = GRID_ROW(a->seen, float, row);
        for (Py_ssize_t i = 0; i < a->seen.cols; i++)
            pixels[i] = 0.0f;
    }
    for (Py_ssize_t row = 0; row < a->depth.rows; row++) {
        const float *restrict depth = GRID_ROW(a->depth, float, row);
        const float *restrict across = GRID_ROW(a->across, float, row);
        const float *restrict down = GRID_ROW(a->down, float, row);
        for (Py_ssize_t i = 0; i < a->depth.cols; i++) {
            const float d = depth[i];
            if (!(d > 0.0f && isfinite(d)))
                continue;
            const float x = across[i] * d, y = down[i] * d;
            const float z = t[2][0] * x + t[2][1] * y + t[2][2] * d + t[2][3];
            if (z > NEAREST_M)
                put(&a->seen, &camera, t[0][0] * x + t[0][1] * y + t[0][2] * d + t[0][3],
                    t[1][0] * x + t[1][1] * y + t[1][2] * d + t[1][3], z, d);
        }
    }
}

PyObject *kernel_register_depth(PyObject *Py_UNUSED(module), PyObject *const *args,
                                Py_ssize_t count)
{
    static const GridSpec specs[] = {
        {'f', 1, "seen"}, {'f', 0, "depth_m"}, {'f', 0, "across"}, {'f', 0, "down"}};
    enum { ARRAYS = 4, NUMBERS = 18 };
    Arrays arrays;
    Numbers numbers;
    if (count_is("register_depth", count, ARRAYS + NUMBERS) < 0 ||
        numbers_of(numbers.all, args + ARRAYS, NUMBERS) < 0 ||
        grids_open(arrays.all, args, specs, ARRAYS) < 0)
        return NULL;
    const int alike = grids_alike(arrays.all + 1, specs + 1, 3);
    if (alike == 0) {
        Py_BEGIN_ALLOW_THREADS
        register_all(&arrays, &numbers);
        Py_END_ALLOW_THREADS
    }
    grids_close(arrays.all, ARRAYS);
    if (alike < 0)
        return NULL;
    Py_RETURN_NONE;
}
