/* What the planner sees of a window of the map, of the distance to the nearest obstacle. See
 * runtime/core/distances/terrain.py. */
#include "arguments.h"
#include <math.h>

/* Both in the order in which Python gives them. */
typedef union {
    Grid all[7];
    struct {
        Grid distance, free, driven, dead_end, clearance, passable, speed; /* of the window */
    };
} Layers;

typedef union {
    double all[15];
    struct {
        double cell_m, x0_m, y0_m, first_row, first_col; /* where the window lies */
        double x_m, y_m;                                 /* where the robot is */
        double most_m, hard_m, comfort_m, slowest; /* of clearance; the speed at an obstacle */
        double squeeze_m, loose_m; /* so near to the robot cells of that clearance are clear */
        double escape_m, dead_end_m; /* so near to it free cells pass, and dead ends are open */
    };
} SurveyRules;

static void clear(const Layers *layers, const SurveyRules *rules, Py_ssize_t row)
{
    const float cell = (float)rules->cell_m, half = (float)(rules->cell_m / 2);
    const float most = (float)rules->most_m, hard = (float)rules->hard_m;
    const float *restrict distance = GRID_ROW(layers->distance, float, row);
    const uint8_t *restrict open = GRID_ROW(layers->free, uint8_t, row);
    const uint8_t *restrict driven = GRID_ROW(layers->driven, uint8_t, row);
    float *restrict clearance = GRID_ROW(layers->clearance, float, row);
    for (Py_ssize_t i = 0; i < layers->free.cols; i++) {
        const float edge = distance[i] * cell - half;
        const float held = edge < most ? edge : most;
        const int proven = (open[i] != 0) & (driven[i] != 0);
        clearance[i] = proven & (held < hard) ? hard : held;
    }
}

/* The columns whose middles are no farther from the robot along x than the radius. */
static void columns(const SurveyRules *rules, double radius_m, Py_ssize_t cols, Py_ssize_t *first,
                    Py_ssize_t *end)
{
    const double middle = (rules->x_m - rules->x0_m) / rules->cell_m - rules->first_col;
    const double reach = radius_m / rules->cell_m + 2.0;
    const double low = middle - reach, high = middle + reach;
    *first = low > 0.0 ? (low < (double)cols ? (Py_ssize_t)low : cols) : 0;
    *end = high > 0.0 ? (high < (double)cols ? (Py_ssize_t)high : cols) : 0;
}

static double aside(const SurveyRules *rules, Py_ssize_t col)
{
    return rules->x0_m + (rules->first_col + (double)col + 0.5) * rules->cell_m - rules->x_m;
}

static double ahead(const SurveyRules *rules, Py_ssize_t row)
{
    return rules->y0_m + (rules->first_row + (double)row + 0.5) * rules->cell_m - rules->y_m;
}

static void squeeze(const Layers *layers, const SurveyRules *rules, Py_ssize_t row)
{
    const double y = ahead(rules, row), radius_m = rules->squeeze_m;
    const float hard = (float)rules->hard_m, loose = (float)rules->loose_m;
    const uint8_t *open = GRID_ROW(layers->free, uint8_t, row);
    float *clearance = GRID_ROW(layers->clearance, float, row);
    Py_ssize_t i, end;
    columns(rules, radius_m, layers->free.cols, &i, &end);
    for (; i < end; i++)
        if (open[i] && clearance[i] >= loose && clearance[i] < hard &&
            hypot(aside(rules, i), y) <= radius_m)
            clearance[i] = hard;
}

static void pass(const Layers *layers, const SurveyRules *rules, Py_ssize_t row)
{
    const float hard = (float)rules->hard_m;
    const uint8_t *restrict open = GRID_ROW(layers->free, uint8_t, row);
    const uint8_t *restrict dead_end = GRID_ROW(layers->dead_end, uint8_t, row);
    const float *restrict clearance = GRID_ROW(layers->clearance, float, row);
    uint8_t *restrict passable = GRID_ROW(layers->passable, uint8_t, row);
    const double y = ahead(rules, row);
    const double widest = fmax(rules->escape_m, rules->dead_end_m);
    Py_ssize_t i, end;
    for (i = 0; i < layers->free.cols; i++)
        passable[i] = (uint8_t)((open[i] != 0) & (clearance[i] >= hard) & !dead_end[i]);
    if (fabs(y) > widest)
        return;
    columns(rules, widest, layers->free.cols, &i, &end);
    for (; i < end; i++) {
        if (!open[i] || passable[i])
            continue;
        const double away = hypot(aside(rules, i), y);
        passable[i] = away <= rules->dead_end_m || (away <= rules->escape_m && !dead_end[i]);
    }
}

static void pace(const Layers *layers, const SurveyRules *rules, Py_ssize_t row)
{
    const float hard = (float)rules->hard_m, comfort = (float)rules->comfort_m;
    const float slowest = (float)rules->slowest, rest = (float)(1.0 - rules->slowest);
    const float *restrict clearance = GRID_ROW(layers->clearance, float, row);
    const uint8_t *restrict passable = GRID_ROW(layers->passable, uint8_t, row);
    float *restrict speed = GRID_ROW(layers->speed, float, row);
    for (Py_ssize_t i = 0; i < layers->free.cols; i++) {
        float ease = (clearance[i] - hard) / comfort;
        ease = ease > 0.0f ? ease : 0.0f;
        ease = ease < 1.0f ? ease : 1.0f;
        const float fast = slowest + rest * ease;
        speed[i] = passable[i] ? fast : 0.0f;
    }
}

static void survey(const Layers *layers, const SurveyRules *rules)
{
    for (Py_ssize_t row = 0; row < layers->free.rows; row++) {
        clear(layers, rules, row);
        if (rules->squeeze_m > 0.0 && fabs(ahead(rules, row)) <= rules->squeeze_m)
            squeeze(layers, rules, row);
        pass(layers, rules, row);
        pace(layers, rules, row);
    }
}

PyObject *kernel_survey(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'f', 0, "distance"}, {0, 0, "free"},     {0, 0, "driven"},
                                     {0, 0, "dead_end"},   {'f', 1, "clearance_m"},
                                     {0, 1, "traversable"}, {'f', 1, "speed"}};
    Layers layers;
    SurveyRules rules;
    if (count_is("survey", count, 22) < 0 || numbers_of(rules.all, args + 7, 15) < 0)
        return NULL;
    if (!(rules.cell_m > 0.0 && rules.comfort_m > 0.0))
        return failed("survey", "cell_m, comfort_m: not more than 0");
    if (grids_open(layers.all, args, specs, 7) < 0)
        return NULL;
    const int alike = grids_alike(layers.all, specs, 7);
    if (alike == 0) {
        Py_BEGIN_ALLOW_THREADS
        survey(&layers, &rules);
        Py_END_ALLOW_THREADS
    }
    grids_close(layers.all, 7);
    if (alike < 0)
        return NULL;
    Py_RETURN_NONE;
}
