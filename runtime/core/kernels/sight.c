/* Straight lines over the map, and whether anything stands on them. See keyframes.py. */
#include "arguments.h"
#include <math.h>

typedef struct {
    double x0_m, y0_m, cell_m, first_row, first_col; /* where the grid lies: as `GridFrame` */
    double x_m, y_m;                                 /* where the lines begin */
    double steps;                                    /* points of a line, its end among them */
} Lines;

static int is_clear(const Grid *occupied, const Lines *lines, double to_x, double to_y)
{
    const double share = 1.0 / (lines->steps - 1.0);
    for (double n = 0.0; n < lines->steps - 1.0; n++) {
        const double x_m = lines->x_m + n * share * to_x, y_m = lines->y_m + n * share * to_y;
        const double row = floor((y_m - lines->y0_m) / lines->cell_m) - lines->first_row;
        const double col = floor((x_m - lines->x0_m) / lines->cell_m) - lines->first_col;
        const int inside = row >= 0.0 && row < (double)occupied->rows && col >= 0.0 &&
                           col < (double)occupied->cols;
        if (inside && GRID_ROW(*occupied, uint8_t, (Py_ssize_t)row)[(Py_ssize_t)col])
            return 0;
    }
    return 1;
}

PyObject *kernel_in_sight(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{BYTES, 1, "seen"}, {BYTES, 0, "occupied"}, {'d', 0, "ends"}};
    Grid grids[3];
    double numbers[8];
    const char *problem = "seen, ends: not (1, N) and (N, 2)";
    if (count_is("in_sight", count, 11) < 0 || numbers_of(numbers, args + 3, 8) < 0)
        return NULL;
    const Lines lines = {numbers[0], numbers[1], numbers[2], numbers[3],
                         numbers[4], numbers[5], numbers[6], numbers[7]};
    if (!(lines.cell_m > 0.0 && lines.steps >= 2.0 && lines.steps < 1e6))
        return failed("in_sight", "cell_m, steps: must be above 0, and 2 or more");
    if (grids_open(grids, args, specs, 3) < 0)
        return NULL;
    if (grids[0].rows == 1 && grids[2].cols == 2 && grids[0].cols == grids[2].rows) {
        problem = NULL;
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t n = 0; n < grids[2].rows; n++) {
            const double *end = GRID_ROW(grids[2], double, n);
            const int clear = is_clear(&grids[1], &lines, end[0] - lines.x_m, end[1] - lines.y_m);
            GRID_ROW(grids[0], uint8_t, 0)[n] = (uint8_t)clear;
        }
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 3);
    if (problem)
        return failed("in_sight", problem);
    Py_RETURN_NONE;
}
