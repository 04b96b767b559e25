/* Which cells with an obstacle are seen through now, at the heights at which something stood in them:
 * see runtime/core/mapping/grid.py. */
#include "windows.h"
#include <math.h>

enum { BANDS = 8, FEET = 1 }; /* heights, each a bit of a cell; the lowest, just above the floor */
enum { BETWEEN = 15 };        /* parts of what is between two heights, in which flat things are looked for */

typedef union {
    Grid all[3];
    struct {
        Grid evidence, stood, depth;
    };
} Arrays;

/* In the order in which Python gives them. */
typedef union {
    double all[31];
    struct {
        double x0_m, y0_m, cell_m, cells_around; /* the grid's corner */
        double x_m, y_m, cosine, sine;           /* of the base */
        double mount_m[3], turn[9];              /* from the optical to the base frame, by rows */
        double fx, fy, cx, cy;
        double max_depth_m, lowest_m, apart_m; /* what is read beyond is none; heights: first, between */
        double margin_m, slack, miss;
        double flat_m; /* what stood at no height is looked for from so near */
    };
} Numbers;

/* What is read where a height of a cell is in the image. */
typedef struct {
    uint8_t passed, blocked, here; /* a bit each: all beyond it, some of it not, some of it there */
} Sight;

/* All across the cell, so that nothing thin stands beside a ray that passes. */
static void look(const Grid *depth, const Numbers *n, const double at[3], uint8_t bit, Sight *sight)
{
    const double away = at[2];
    if (!(away > 0.1 && away <= n->max_depth_m))
        return;
    const double half = n->fx * n->cell_m / 2.0 / away;
    const double u = n->fx * at[0] / away + n->cx, v = n->fy * at[1] / away + n->cy;
    if (!(u - half >= 0.0 && u + half < (double)depth->cols && v >= 0.0 && v < (double)depth->rows))
        return;
    const double least = away + n->margin_m + n->slack * away;
    const double nearest = away - n->margin_m - n->slack * away;
    const float *row = GRID_ROW(*depth, float, (Py_ssize_t)v);
    const Py_ssize_t last = (Py_ssize_t)(u + half);
    int known = 1, blocked = 0, here = 0;
    for (Py_ssize_t col = (Py_ssize_t)(u - half); col <= last; col++) {
        const double read = (double)row[col];
        const int valid = read > 0.0 && read <= n->max_depth_m;
        known &= valid;
        blocked |= valid && read < least;
        here |= valid && read < least && read >= nearest;
    }
    sight->passed |= known && !blocked ? bit : 0;
    sight->blocked |= blocked ? bit : 0;
    sight->here |= here ? bit : 0;
}

/* Where a height of a cell is, in the optical frame. */
typedef struct {
    double level[3], turn[3], foot_m; /* level and turn: what is added for each m of height */
} Upright;

static void at_height(const Upright *cell, double up_m, double at[3])
{
    for (int k = 0; k < 3; k++)
        at[k] = cell->level[k] + cell->turn[k] * up_m;
}

static Upright upright_of(const Numbers *n, Py_ssize_t row, Py_ssize_t col)
{
    const double dx = n->x0_m + ((double)col + 0.5) * n->cell_m - n->x_m;
    const double dy = n->y0_m + ((double)row + 0.5) * n->cell_m - n->y_m;
    const double ahead = n->cosine * dx + n->sine * dy - n->mount_m[0];
    const double aside = n->cosine * dy - n->sine * dx - n->mount_m[1];
    Upright cell = {.foot_m = n->lowest_m - n->mount_m[2]};
    for (int k = 0; k < 3; k++) {
        cell.level[k] = n->turn[k] * ahead + n->turn[3 + k] * aside;
        cell.turn[k] = n->turn[6 + k];
    }
    return cell;
}

static Sight sight_of(const Grid *depth, const Numbers *n, const Upright *cell)
{
    Sight sight = {0, 0, 0};
    for (int band = 0; band < BANDS; band++) {
        double at[3];
        at_height(cell, cell->foot_m + band * n->apart_m, at);
        look(depth, n, at, (uint8_t)(1 << band), &sight);
    }
    return sight;
}

/* Whether something may be in a cell between the heights: a table's top is flat, and from afar may
 * be thinner than a pixel. */
static int may_hold(const Grid *depth, const Numbers *n, const Upright *cell, int stood)
{
    const double step_m = n->apart_m / BETWEEN;
    double foot[3];
    at_height(cell, cell->foot_m, foot);
    if (!stood && foot[2] > n->flat_m)
        return 1;
    for (int part = 0; part <= (BANDS - 1) * BETWEEN; part++) {
        double at[3];
        Sight sight = {0, 0, 0};
        at_height(cell, cell->foot_m + part * step_m, at);
        look(depth, n, at, 1, &sight);
        if (sight.here)
            return 1;
    }
    return 0;
}

static int count_of(unsigned bits)
{
    int count = 0;
    for (; bits; bits &= bits - 1)
        count++;
    return count;
}

/* Books what a cell shows at the heights; whether nothing is left of what stood there. */
static int passed(uint8_t *stood, Sight sight)
{
    enum { ENOUGH = 3 }; /* heights: what has stood there has gone, whatever is below the image */
    *stood |= sight.here;
    if (sight.blocked & (*stood ? *stood : 0xFF)) {
        *stood &= (uint8_t)~sight.passed;
        return 0;
    }
    return (sight.passed & FEET) || count_of(sight.passed & *stood) >= ENOUGH;
}

/* The same of its evidence; whether that is less. */
static int weigh(const Arrays *arrays, const Numbers *n, Py_ssize_t row, Py_ssize_t col)
{
    int16_t *evidence = GRID_ROW(arrays->evidence, int16_t, row) + col;
    uint8_t *stood = GRID_ROW(arrays->stood, uint8_t, row) + col;
    const Upright cell = upright_of(n, row, col);
    if (!passed(stood, sight_of(&arrays->depth, n, &cell)))
        return 0;
    if (may_hold(&arrays->depth, n, &cell, *stood))
        return 0;
    *evidence = (int16_t)(*evidence - (int)n->miss);
    *stood = *evidence > 0 ? *stood : 0;
    return 1;
}

static Box see_through(Arrays *arrays, const Numbers *n)
{
    const Grid *evidence = &arrays->evidence;
    const double row = floor((n->y_m - n->y0_m) / n->cell_m);
    const double col = floor((n->x_m - n->x0_m) / n->cell_m);
    Box found = NO_BOX;
    const double rows = (double)evidence->rows, cols = (double)evidence->cols;
    const Py_ssize_t top = (Py_ssize_t)greater(0.0, lesser(rows, row - n->cells_around));
    const Py_ssize_t bottom = (Py_ssize_t)greater(0.0, lesser(rows, row + n->cells_around + 1.0));
    const Py_ssize_t left = (Py_ssize_t)greater(0.0, lesser(cols, col - n->cells_around));
    const Py_ssize_t right = (Py_ssize_t)greater(0.0, lesser(cols, col + n->cells_around + 1.0));
    for (Py_ssize_t y = top; y < bottom; y++) {
        const int16_t *line = GRID_ROW(*evidence, int16_t, y);
        uint8_t *stood = GRID_ROW(arrays->stood, uint8_t, y);
        for (Py_ssize_t x = left; x < right; x++) {
            if (line[x] <= 0)
                stood[x] = 0;
            else if (weigh(arrays, n, y, x))
                box_join_row(&found, y, x, x + 1);
        }
    }
    return found;
}

static const char *problem_of(const Numbers *n)
{
    for (int k = 0; k < 31; k++)
        if (!(fabs(n->all[k]) < 1e9))
            return "view: a number that is none of a camera's";
    if (!(n->cell_m > 0.0 && n->cells_around >= 0.0 && n->miss >= 0.0 && n->miss < 1e4))
        return "view: no cells, or no evidence";
    return NULL;
}

PyObject *kernel_see_through(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'h', 1, "evidence"}, {'B', 1, "stood"}, {'f', 0, "depth_m"}};
    enum { ARRAYS = 3, NUMBERS = 31 };
    Arrays arrays;
    Numbers numbers;
    Box changed = NO_BOX;
    if (count_is("see_through", count, ARRAYS + NUMBERS) < 0 ||
        numbers_of(numbers.all, args + ARRAYS, NUMBERS) < 0 ||
        grids_open(arrays.all, args, specs, ARRAYS) < 0)
        return NULL;
    const int alike = grids_alike(arrays.all, specs, 2);
    const char *problem = problem_of(&numbers);
    if (alike == 0 && !problem) {
        Py_BEGIN_ALLOW_THREADS
        changed = see_through(&arrays, &numbers);
        Py_END_ALLOW_THREADS
    }
    grids_close(arrays.all, ARRAYS);
    if (alike < 0)
        return NULL;
    return problem ? failed("see_through", problem) : box_as_tuple(&changed);
}
