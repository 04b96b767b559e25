/* Ways of several whole steps through tight places. See motion/step_search.py. */
#include "arguments.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    double x0_m, y0_m, cell_m, first_row, first_col; /* where a grid lies: as `GridFrame` */
} Place;

typedef struct {
    double needed_m, slack_m; /* clearance of the body, and by how little less still is as much */
    Py_ssize_t samples;       /* along a step, its beginning left out */
} Body;

/* The clearance between the centres of the cells around a point, which have others around them. */
static int clearance_at(const Grid *grid, const Place *at, double x_m, double y_m, double *found)
{
    const double row = floor((y_m - at->y0_m) / at->cell_m) - at->first_row;
    const double col = floor((x_m - at->x0_m) / at->cell_m) - at->first_col;
    if (!(row >= 1.0 && col >= 1.0 && row < (double)(grid->rows - 1) &&
          col < (double)(grid->cols - 1)))
        return 0;
    const double u = (x_m - at->x0_m) / at->cell_m - 0.5, v = (y_m - at->y0_m) / at->cell_m - 0.5;
    const double left = floor(u), low = floor(v), x = u - left, y = v - low;
    const Py_ssize_t c = (Py_ssize_t)(left - at->first_col), r = (Py_ssize_t)(low - at->first_row);
    const float *below = GRID_ROW(*grid, float, r), *above = GRID_ROW(*grid, float, r + 1);
    const double bottom = below[c] * (1.0 - x) + below[c + 1] * x;
    const double top = above[c] * (1.0 - x) + above[c + 1] * x;
    *found = bottom * (1.0 - y) + top * y;
    return 1;
}

/* Whether the body keeps its clearance along a step, or where it has less already loses no more. */
static int keeps_clear(const Grid *grid, const Place *at, const Body *body, const double *from,
                       const double *step)
{
    double most = -INFINITY;
    for (Py_ssize_t n = 0; n <= body->samples; n++) {
        const double share = n == body->samples ? 1.0 : (double)n * (1.0 / (double)body->samples);
        double here;
        if (!clearance_at(grid, at, from[0] + share * step[0], from[1] + share * step[1], &here))
            return 0;
        most = greater(most, here);
        if (here < lesser(body->needed_m, most) - body->slack_m)
            return 0;
    }
    return 1;
}

static int body_of(Body *body, const double *numbers)
{
    *body = (Body){numbers[0], numbers[1], (Py_ssize_t)numbers[2]};
    return numbers[2] >= 1.0 && numbers[2] < 1e6;
}

PyObject *kernel_steps_clear(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {
        {BYTES, 1, "clear"}, {'f', 0, "clearance_m"}, {'d', 0, "from_xy"}, {'d', 0, "steps"}};
    Grid grids[4];
    Place at;
    Body body;
    double numbers[3];
    if (count_is("steps_clear", count, 6) < 0 || numbers_in(&at.x0_m, 5, args[4], "place") < 0 ||
        numbers_in(numbers, 3, args[5], "body") < 0)
        return NULL;
    if (!body_of(&body, numbers) || !(at.cell_m > 0.0))
        return failed("steps_clear", "place, body: cell_m must be above 0, samples 1 or more");
    if (grids_open(grids, args, specs, 4) < 0)
        return NULL;
    const Py_ssize_t steps = grids[2].rows;
    const int right = grids[0].rows == 1 && grids[0].cols == steps && grids[3].rows == steps &&
                      grids[2].cols == 2 && grids[3].cols == 2;
    if (right) {
        Py_BEGIN_ALLOW_THREADS
        for (Py_ssize_t n = 0; n < steps; n++)
            GRID_ROW(grids[0], uint8_t, 0)[n] = (uint8_t)keeps_clear(
                &grids[1], &at, &body, GRID_ROW(grids[2], double, n), GRID_ROW(grids[3], double, n));
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 4);
    if (!right)
        return failed("steps_clear", "clear, from_xy, steps: not (1, N), (N, 2) and (N, 2)");
    Py_RETURN_NONE;
}

/* A place that steps reach. */
typedef struct {
    double x_m, y_m, left_m;
    int32_t before, turned; /* the place that the last step began at, and that step's turns */
    int32_t facing, turns;  /* turns from the first heading, to the left; and made in all */
    int32_t order;          /* in which it was found, among those of its layer */
} Reached;

typedef struct {
    double reach_m, same_m, best_m;      /* see step_search.py */
    double most_steps;
    double least_turn, most_turn; /* whole turns before a step: from, to, both included */
} Rules;

typedef struct {
    const Grid *clearance, *arrival, *steps; /* steps: (F, 2) m by facing, the middle one is 0 */
    Place terrain, field;
    Body body;
    Rules rules;
    Reached *places; /* all, the start first */
    int32_t *table;  /* by key one more than the place there, 0: none */
    Py_ssize_t side, count;
    double key_x, key_y; /* of the table's first */
} Search;

static double arrival_at(const Search *s, double x_m, double y_m)
{
    const Place *at = &s->field;
    const double row = floor((y_m - at->y0_m) / at->cell_m) - at->first_row;
    const double col = floor((x_m - at->x0_m) / at->cell_m) - at->first_col;
    if (!(row >= 0.0 && col >= 0.0 && row < (double)s->arrival->rows &&
          col < (double)s->arrival->cols))
        return INFINITY;
    return GRID_ROW(*s->arrival, double, (Py_ssize_t)row)[(Py_ssize_t)col];
}

/* One step from a place of the layer before; `first` is the first place of this one. Of those that
 * end in one place the one with the fewest turns is kept, the first of equals. */
static void try_step(Search *s, int32_t from, int32_t turned, Py_ssize_t first, int32_t order)
{
    const Reached *base = &s->places[from], *start = s->places;
    const int32_t facing = base->facing + turned;
    const double *step = GRID_ROW(*s->steps, double, facing + (s->steps->rows - 1) / 2);
    const double begin[2] = {base->x_m, base->y_m};
    const double x_m = begin[0] + step[0], y_m = begin[1] + step[1];
    const double left_m = arrival_at(s, x_m, y_m);
    if (!isfinite(left_m) || hypot(x_m - start->x_m, y_m - start->y_m) > s->rules.reach_m)
        return;
    const double col = rint(x_m / s->rules.same_m) - s->key_x;
    const double row = rint(y_m / s->rules.same_m) - s->key_y;
    int32_t *slot = &s->table[(Py_ssize_t)row * s->side + (Py_ssize_t)col];
    const int32_t turns = base->turns + abs(turned);
    if (*slot && (*slot - 1 < first || s->places[*slot - 1].turns <= turns))
        return;
    if (!keeps_clear(s->clearance, &s->terrain, &s->body, begin, step))
        return;
    if (!*slot)
        *slot = (int32_t)++s->count;
    s->places[*slot - 1] = (Reached){x_m, y_m, left_m, from, turned, facing, turns, order};
}

static int fewer_turns(const void *one, const void *other)
{
    const Reached *a = one, *b = other;
    return a->turns != b->turns ? (a->turns > b->turns) - (a->turns < b->turns)
                                : (a->order > b->order) - (a->order < b->order);
}

/* Breadth first; the place that a way leads to, or -1, and the place nearest to the sources. */
static int32_t search(Search *s, int32_t *nearest)
{
    Py_ssize_t layer = 0, first = 1;
    double nearest_m = arrival_at(s, s->places[0].x_m, s->places[0].y_m);
    *nearest = 0;
    for (double n = 0.0; n < s->rules.most_steps && layer < first; n++) {
        int32_t order = 0;
        for (Py_ssize_t from = layer; from < first; from++)
            for (int32_t turned = (int32_t)s->rules.least_turn; turned <= s->rules.most_turn; turned++)
                try_step(s, (int32_t)from, turned, first, order++);
        qsort(s->places + first, (size_t)(s->count - first), sizeof *s->places, fewer_turns);
        for (Py_ssize_t place = first; place < s->count; place++)
            if (s->places[place].left_m <= s->rules.best_m)
                return (int32_t)place;
        for (Py_ssize_t place = first; place < s->count; place++) {
            if (s->places[place].left_m < nearest_m) {
                nearest_m = s->places[place].left_m;
                *nearest = (int32_t)place;
            }
        }
        layer = first;
        first = s->count;
    }
    return -1;
}

/* The turns before each step of the way to a place, and where it leads. */
static PyObject *way_to(const Search *s, int32_t found, int32_t nearest)
{
    signed char turns[256];
    Py_ssize_t left = sizeof turns;
    for (int32_t place = found; place > 0; place = s->places[place].before)
        turns[--left] = (signed char)s->places[place].turned;
    const Reached *end = &s->places[found > 0 ? found : nearest];
    return Py_BuildValue("y#dd", (char *)turns + left, (Py_ssize_t)sizeof turns - left, end->x_m,
                         end->y_m);
}

static const char *begin(Search *s, const double *start)
{
    s->key_x = rint((start[0] - s->rules.reach_m) / s->rules.same_m) - 1.0;
    s->key_y = rint((start[1] - s->rules.reach_m) / s->rules.same_m) - 1.0;
    s->side = (Py_ssize_t)(2.0 * s->rules.reach_m / s->rules.same_m) + 5;
    s->table = calloc((size_t)(s->side * s->side), sizeof *s->table);
    s->places = malloc((size_t)(s->side * s->side + 1) * sizeof *s->places);
    if (!s->table || !s->places)
        return NO_MEMORY;
    s->places[0] = (Reached){start[0], start[1], INFINITY, -1, 0, 0, 0, 0};
    s->count = 1;
    return NULL;
}

static const char *what_is_wrong(const Search *s, const double *start)
{
    const Rules *r = &s->rules;
    const double turns = lesser(r->most_turn, -r->least_turn);
    if (!(s->terrain.cell_m > 0.0 && s->field.cell_m > 0.0))
        return "terrain, field: cell_m must be above 0";
    if (!(fabs(start[0]) < 1e9 && fabs(start[1]) < 1e9 && r->same_m > 1e-6 && r->reach_m > 0.0 &&
          r->reach_m / r->same_m < 500.0))
        return "start, rules: within 1e9 m; same_m above 1e-6, reach_m up to 500 times as much";
    if (!(r->most_steps >= 0.0 && r->most_steps <= 100.0 && turns >= 0.0 &&
          greater(r->most_turn, -r->least_turn) <= 100.0))
        return "rules: up to 100 steps, of up to 100 turns to each side";
    const double widest = r->most_steps * greater(r->most_turn, -r->least_turn);
    if (s->steps->cols != 2 || s->steps->rows % 2 == 0 ||
        (double)s->steps->rows < 2.0 * widest + 1.0)
        return "steps: not (F, 2), F odd, one for each heading that the turns reach";
    return NULL;
}

PyObject *kernel_whole_steps(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {
        {'f', 0, "clearance_m"}, {'d', 0, "arrival"}, {'d', 0, "steps"}};
    Grid grids[3];
    Search s = {.clearance = &grids[0], .arrival = &grids[1], .steps = &grids[2]};
    double body[3], start[2];
    if (count_is("whole_steps", count, 8) < 0 ||
        numbers_in(&s.terrain.x0_m, 5, args[3], "terrain") < 0 ||
        numbers_in(&s.field.x0_m, 5, args[4], "field") < 0 ||
        numbers_in(body, 3, args[5], "body") < 0 || numbers_in(start, 2, args[6], "start") < 0 ||
        numbers_in(&s.rules.reach_m, 6, args[7], "rules") < 0)
        return NULL;
    if (!body_of(&s.body, body))
        return failed("whole_steps", "body: samples must be 1 or more");
    if (grids_open(grids, args, specs, 3) < 0)
        return NULL;
    const char *problem = what_is_wrong(&s, start);
    int32_t found = -1, nearest = 0;
    if (!problem) {
        Py_BEGIN_ALLOW_THREADS
        problem = begin(&s, start);
        found = problem ? -1 : search(&s, &nearest);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 3);
    PyObject *way = problem ? failed("whole_steps", problem) : way_to(&s, found, nearest);
    free(s.table);
    free(s.places);
    return way;
}
