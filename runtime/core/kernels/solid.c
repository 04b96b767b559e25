/* Depth without flying pixels: see runtime/core/mapping/solid_depth.py. Nine rows of the image at a
 * time are held as inverse depth in 16 bits. */
#include "arguments.h"
#include <stdlib.h>
#include <string.h>

enum { REACH = 2, AROUND = 2 * REACH, HELD = 2 * AROUND + 1 };

typedef struct {
    float units, nearest_m; /* of inverse depth to 1/m; what is nearer counts as there */
    int16_t jump, same;     /* of inverse depth; see solid_depth.py */
} Limits;

static void nearness(const float *restrict depth, int16_t *restrict out, Py_ssize_t n,
                     const Limits *limits)
{
    const float units = limits->units, nearest = limits->nearest_m;
    for (Py_ssize_t i = 0; i < n; i++) {
        const float held = depth[i] > nearest ? depth[i] : nearest;
        out[i] = (int16_t)(depth[i] > 0.0f ? units / held : 0.0f);
    }
}

static inline int16_t low_of(int16_t a, int16_t b) { return a < b ? a : b; }
static inline int16_t high_of(int16_t a, int16_t b) { return a > b ? a : b; }
static inline int16_t less(int16_t a, int16_t b) { return (int16_t)(a - b); }
static inline int16_t apart(int16_t a, int16_t b) { return less(high_of(a, b), low_of(a, b)); }
static inline int16_t bend(int16_t a, int16_t b, int16_t c)
{
    return apart(less(b, a), less(c, b));
}

/* Marks the pixels that fly along a line of which `step` leads from one pixel to the next. */
static void mark(const int16_t *const at[HELD], uint8_t *restrict flies, Py_ssize_t n,
                 const Limits *limits)
{
    const int16_t jump = limits->jump, same = limits->same;
    const int16_t *a = at[0], *b = at[2], *c = at[3], *here = at[4], *e = at[5], *f = at[6],
                  *g = at[8];
    for (Py_ssize_t i = 0; i < n; i++) {
        const int16_t p = here[i], before = less(p, b[i]), after = less(f[i], p);
        const int16_t between =
            high_of(low_of(before, after), less(0, high_of(before, after)));
        const int16_t off = low_of(bend(a[i], b[i], p), bend(p, f[i], g[i]));
        const int16_t alone = low_of(apart(p, c[i]), apart(e[i], p));
        flies[i] |= (uint8_t)((low_of(between, off) > jump) & (alone > same));
    }
}

static int solid(Grid *out, const Grid *depth, const Limits *limits)
{
    const Py_ssize_t rows = depth->rows, cols = depth->cols;
    int16_t *ring = malloc((size_t)(HELD * cols) * sizeof *ring);
    uint8_t *flies = malloc((size_t)cols);
    if (!ring || !flies) {
        free(ring);
        free(flies);
        return -1;
    }
    for (Py_ssize_t row = -AROUND; row < rows; row++) {
        const Py_ssize_t ahead = row + AROUND;
        if (ahead < rows)
            nearness(GRID_ROW(*depth, float, ahead), ring + ahead % HELD * cols, cols, limits);
        if (row < 0)
            continue;
        memset(flies, 0, (size_t)cols);
        const int16_t *at[HELD], *line = ring + row % HELD * cols;
        if (row >= AROUND && ahead < rows) {
            for (int k = 0; k < HELD; k++)
                at[k] = ring + (row - AROUND + k) % HELD * cols;
            mark(at, flies, cols, limits);
        }
        if (cols > 2 * AROUND) {
            for (int k = 0; k < HELD; k++)
                at[k] = line + k;
            mark(at, flies + AROUND, cols - 2 * AROUND, limits);
        }
        const float *from = GRID_ROW(*depth, float, row);
        float *into = GRID_ROW(*out, float, row);
        for (Py_ssize_t col = 0; col < cols; col++)
            into[col] = flies[col] ? 0.0f : from[col];
    }
    free(ring);
    free(flies);
    return 0;
}

PyObject *kernel_solid(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'f', 1, "solid_m"}, {'f', 0, "depth_m"}};
    Grid grids[2];
    double numbers[4];
    int done = 0;
    if (count_is("solid", count, 6) < 0 || numbers_of(numbers, args + 2, 4) < 0)
        return NULL;
    const double units = numbers[0], nearest_m = numbers[1];
    if (!(units > 0.0 && nearest_m > 0.0 && units / nearest_m < 8192.0) ||
        !(numbers[2] >= 0.0 && numbers[2] < 8192.0 && numbers[3] >= 0.0 && numbers[3] < 8192.0))
        return failed("solid", "inverse depth beyond 16 bits");
    if (grids_open(grids, args, specs, 2) < 0)
        return NULL;
    const int alike = grids_alike(grids, specs, 2);
    if (alike == 0) {
        const Limits limits = {(float)units, (float)nearest_m, (int16_t)numbers[2],
                               (int16_t)numbers[3]};
        Py_BEGIN_ALLOW_THREADS
        done = solid(&grids[0], &grids[1], &limits);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 2);
    if (done < 0)
        return PyErr_NoMemory();
    if (alike < 0)
        return NULL;
    Py_RETURN_NONE;
}
