/* What stands near the body, and where near it the floor is missing, of one depth image: the points
 * of its pixels by cell of a small grid around the base. See runtime/core/mapping/near_points.py. */
#include "sampled.h"
#include <math.h>
#include <stdlib.h>

/* Both in the order in which Python gives them. */
typedef union {
    Grid all[5];
    struct {
        Grid found, depth, forward, left, up;
    };
} Arrays;

typedef union {
    double all[14];
    struct {
        double stride, max_depth_m, x_m, y_m, z_m; /* of the camera in the base frame */
        double floor_m, slack, height_m;           /* see Rules in near_points.py */
        double ahead_m, aside_m, behind_m, cell_m;
        double least, least_drops; /* pixels of a cell and its neighbours */
    };
} Numbers;

enum { OBSTACLE = 0, DROP = 1, KINDS = 2, COLUMNS = 5, MOST_CELLS = 1 << 22 };

typedef struct {
    float pixels, x, y, z; /* sums */
    float low;             /* the least z */
} Cell;

typedef struct {
    Cell *cells; /* of all obstacles, then of all drops */
    Py_ssize_t rows, cols;
} Around;

static void add(const Around *around, const Numbers *n, int kind, float x, float y, float z)
{
    if (!(x >= (float)-n->behind_m && x < (float)n->ahead_m && fabsf(y) < (float)n->aside_m))
        return;
    const float per_m = (float)(1.0 / n->cell_m);
    const Py_ssize_t row = (Py_ssize_t)((x + (float)n->behind_m) * per_m);
    const Py_ssize_t col = (Py_ssize_t)((y + (float)n->aside_m) * per_m);
    if (row >= around->rows || col >= around->cols)
        return;
    Cell *cell = &around->cells[(kind * around->rows + row) * around->cols + col];
    cell->low = cell->pixels > 0.0f ? fminf(cell->low, z) : z;
    cell->pixels += 1.0f;
    cell->x += x;
    cell->y += y;
    cell->z += z;
}

static void project(const Arrays *arrays, const Numbers *n, const Around *around, Py_ssize_t row)
{
    const Py_ssize_t stride = (Py_ssize_t)n->stride;
    const float *restrict depth = sampled_row(&arrays->depth, stride, row);
    const float *restrict forward = GRID_ROW(arrays->forward, float, row);
    const float *restrict left = GRID_ROW(arrays->left, float, row);
    const float *restrict up = GRID_ROW(arrays->up, float, row);
    const float max_depth = (float)n->max_depth_m, camera = (float)n->z_m;
    const float floor_m = (float)n->floor_m, slack = (float)n->slack;
    const float height_m = (float)n->height_m, ahead_m = (float)(n->ahead_m - n->x_m);
    for (Py_ssize_t i = 0; i < arrays->up.cols; i++) {
        const float d = depth[i * stride];
        if (!(d > 0.0f && d <= max_depth))
            continue;
        const float height = d * up[i] + camera;
        if (height > height_m)
            continue;
        const float ahead = d * forward[i], aside = d * left[i];
        if (height >= floor_m) {
            if (ahead < ahead_m && height >= floor_m + slack * hypotf(ahead, aside))
                add(around, n, OBSTACLE, ahead + (float)n->x_m, aside + (float)n->y_m, height);
        } else if (height < -floor_m && height < -(floor_m + slack * hypotf(ahead, aside))) {
            const float share = camera / -up[i]; /* of the ray, to the floor's plane */
            add(around, n, DROP, share * forward[i] + (float)n->x_m,
                share * left[i] + (float)n->y_m, height);
        }
    }
}

/* Pixels of a cell and of those that touch it. */
static float together(const Around *around, int kind, Py_ssize_t row, Py_ssize_t col)
{
    float pixels = 0.0f;
    for (Py_ssize_t r = row > 0 ? row - 1 : 0; r <= row + 1 && r < around->rows; r++)
        for (Py_ssize_t c = col > 0 ? col - 1 : 0; c <= col + 1 && c < around->cols; c++)
            pixels += around->cells[(kind * around->rows + r) * around->cols + c].pixels;
    return pixels;
}

/* The cells of enough pixels, each as the middle of its points; how many, of all that there are. */
static Py_ssize_t collect(const Arrays *arrays, const Numbers *n, const Around *around)
{
    Py_ssize_t count = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        const float least = (float)(kind == DROP ? n->least_drops : n->least);
        for (Py_ssize_t row = 0; row < around->rows; row++) {
            const Cell *cells = &around->cells[(kind * around->rows + row) * around->cols];
            for (Py_ssize_t col = 0; col < around->cols; col++) {
                const float pixels = cells[col].pixels;
                if (!(pixels > 0.0f) || together(around, kind, row, col) < least)
                    continue;
                if (count < arrays->found.rows) {
                    float *point = GRID_ROW(arrays->found, float, count);
                    point[0] = cells[col].x / pixels;
                    point[1] = cells[col].y / pixels;
                    point[2] = cells[col].z / pixels;
                    point[3] = (float)kind;
                    point[4] = cells[col].low;
                }
                count++;
            }
        }
    }
    return count;
}

static const char *problem_of(const Arrays *a, const Numbers *n)
{
    const char *problem = sampling_problem(&a->depth, &a->up, n->stride);
    if (problem)
        return problem;
    if (a->found.cols != COLUMNS)
        return "found: not five columns";
    if (!(n->cell_m > 0.0 && n->ahead_m > 0.0 && n->aside_m > 0.0 && n->behind_m >= 0.0 &&
          ((n->ahead_m + n->behind_m) / n->cell_m + 2.0) * (2.0 * n->aside_m / n->cell_m + 2.0) <
              MOST_CELLS))
        return TOO_MANY_CELLS;
    return NULL;
}

PyObject *kernel_near_points(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'f', 1, "found"},
                                     {'f', 0, "depth_m"},
                                     {'f', 0, "forward"},
                                     {'f', 0, "left"},
                                     {'f', 0, "up"}};
    enum { ARRAYS = 5, NUMBERS = 14 };
    Arrays arrays;
    Numbers numbers;
    if (count_is("near_points", count, ARRAYS + NUMBERS) < 0 ||
        numbers_of(numbers.all, args + ARRAYS, NUMBERS) < 0 ||
        grids_open(arrays.all, args, specs, ARRAYS) < 0)
        return NULL;
    const int alike = grids_alike(arrays.all + 2, specs + 2, 3);
    const char *problem = alike < 0 ? NULL : problem_of(&arrays, &numbers);
    Py_ssize_t found = 0;
    if (alike == 0 && !problem) {
        Around around = {
            .rows = (Py_ssize_t)ceil((numbers.ahead_m + numbers.behind_m) / numbers.cell_m),
            .cols = (Py_ssize_t)ceil(2.0 * numbers.aside_m / numbers.cell_m)};
        around.cells = calloc((size_t)(KINDS * around.rows * around.cols), sizeof *around.cells);
        if (!around.cells)
            problem = NO_MEMORY;
        else {
            Py_BEGIN_ALLOW_THREADS
            for (Py_ssize_t row = 0; row < arrays.up.rows; row++)
                project(&arrays, &numbers, &around, row);
            found = collect(&arrays, &numbers, &around);
            Py_END_ALLOW_THREADS
            free(around.cells);
        }
    }
    grids_close(arrays.all, ARRAYS);
    if (problem)
        return failed("near_points", problem);
    return alike < 0 ? NULL : PyLong_FromSsize_t(found);
}
