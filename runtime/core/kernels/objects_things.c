/* The things in a detector's boxes: which pixels are of each, and where in the map they are. */
#include "objects_view.h"
#include <math.h>
#include <stdlib.h>

static const double MOST_M = 100.0; /* of a thing, along each axis */
enum { LEAST_RIM = 3, MOST_RIM = 1000000000 };

typedef struct {
    double near_m, x, y, z, low, high;
    Footprint cells; /* of which arrays are its own */
} Thing;

/* Marks the labels that have something as far away as that. */
static void mark_attached(View *view, Box box, float near_m, int32_t number)
{
    const float edge = (float)view->rules->edge_m;
    for (Py_ssize_t row = box.top; row < box.bottom; row++) {
        const float *depth = view->depth + row * view->surfaces.cols;
        const int32_t *labels = view->surfaces.label + row * view->surfaces.cols;
        for (Py_ssize_t col = box.left; col < box.right; col++)
            if (fabsf(depth[col] - near_m) <= edge)
                view->wanted[labels[col]] = number;
    }
    view->wanted[0] = 0;
}

/* The points of a thing that is so far away, and as wide as the box per metre of it; how many. */
static size_t points_of(View *view, Box box, double near_m, double wide, int32_t number,
                        double *x, double *y, double *z)
{
    const SegmentRules *rules = view->rules;
    const Place at = view->place;
    double before_m = rules->before_share * wide * near_m;
    before_m = before_m > rules->before_m ? before_m : rules->before_m;
    before_m = before_m < rules->cluster_m ? before_m : rules->cluster_m;
    const float from = (float)(near_m - before_m), to = (float)(near_m + rules->cluster_m);
    const float behind = (float)(near_m - rules->edge_m);
    size_t n = 0;
    mark_attached(view, box, (float)near_m, number);
    for (Py_ssize_t row = box.top; row < box.bottom; row++) {
        const float *standing = view->standing + row * view->surfaces.cols;
        const int32_t *label = view->surfaces.label + row * view->surfaces.cols;
        const float *ahead = GRID_ROW(view->forward, float, row);
        const float *left = GRID_ROW(view->left, float, row);
        const float *up = GRID_ROW(view->up, float, row);
        for (Py_ssize_t col = box.left; col < box.right; col++) {
            const float depth = standing[col];
            if (!(depth > from && depth < to) ||
                !(depth > behind || view->wanted[label[col]] == number))
                continue;
            const double base_x = (double)ahead[col] * (double)depth + at.camera_x;
            const double base_y = (double)left[col] * (double)depth + at.camera_y;
            x[n] = at.cos * base_x - at.sin * base_y + at.x;
            y[n] = at.sin * base_x + at.cos * base_y + at.y;
            z[n++] = (double)up[col] * (double)depth + at.camera_z;
        }
    }
    return n;
}

/* Whether points are no farther apart than those of a thing. */
static int is_near(Range range) { return range.high - range.low <= MOST_M; }

/* The middle of n points, their height without strays at the rim, and the cells under them; nothing
 * where they are not of one thing, but of a sensor's fault. */
static const char *measured(const View *view, Thing *thing, const double *x, const double *y,
                            const double *z, size_t n, double *scratch)
{
    const Points points = {x, y, n, range_of(x, n), range_of(y, n)};
    if (!is_near(points.across) || !is_near(points.along))
        return NULL;
    double *cells = malloc(2 * n * sizeof *cells), found[4];
    if (!cells)
        return NO_MEMORY;
    thing->cells = (Footprint){cells, cells + n, 0};
    const char *problem =
        footprint(&view->frame, &points, &thing->cells, (int32_t *)(void *)scratch);
    if (problem) {
        free(cells);
        thing->cells.x = NULL;
        return problem == NOWHERE ? NULL : problem;
    }
    without_strays(&thing->cells, view->rules->strays, scratch);
    const size_t rim = n / (size_t)view->rules->rim;
    const size_t ranks[4] = {rim, (n - 1) / 2, n / 2, n - 1 - rim};
    at_ranks(z, n, ranks, 4, found, scratch);
    thing->low = found[0];
    thing->z = (found[1] + found[2]) / 2.0;
    thing->high = found[3];
    thing->x = median_in(x, n, points.across, scratch);
    thing->y = median_in(y, n, points.along, scratch);
    return NULL;
}

/* A box's row is its top, left, bottom and right end, the distance of the thing in it, m, if that
 * is known, and its width per metre of that. */
static const char *thing_in(View *view, const double *row, int32_t number, Thing *thing)
{
    const double h = (double)view->surfaces.rows, w = (double)view->surfaces.cols;
    if (!(row[0] >= 0.0 && row[1] >= 0.0))
        return "boxes: one begins before the image";
    Box box = {.top = (Py_ssize_t)fmin(row[0], h), .left = (Py_ssize_t)fmin(row[1], w)};
    box.bottom = (Py_ssize_t)fmax(fmin(row[2], h), (double)box.top);
    box.right = (Py_ssize_t)fmax(fmin(row[3], w), (double)box.left);
    const size_t pixels = (size_t)((box.bottom - box.top) * (box.right - box.left));
    double *x = view->numbers, *y = x + pixels, *z = y + pixels;
    thing->near_m = isnan(row[4]) ? (double)distance(view, box) : row[4];
    const size_t n = points_of(view, box, thing->near_m, row[5], number, x, y, z);
    if ((double)n < view->rules->least_points)
        return NULL;
    return measured(view, thing, x, y, z, n, z + pixels);
}

static PyObject *told(const Thing *things, Py_ssize_t count)
{
    PyObject *list = PyList_New(count);
    for (Py_ssize_t n = 0; list && n < count; n++) {
        const Thing *t = things + n;
        PyObject *one = t->cells.x ? Py_BuildValue("(ddddddN)", t->near_m, t->x, t->y, t->z,
                                                   t->low, t->high, packed(&t->cells))
                                   : Py_NewRef(Py_None);
        if (!one || PyList_SetItem(list, n, one) < 0)
            Py_CLEAR(list);
    }
    return list;
}

static int is_share(double value) { return value >= 0.0 && value <= 1.0; }

/* One in so many points is a stray at the rim: at either end fewer than half of them. */
static int are_rules(const SegmentRules *rules)
{
    return is_share(rules->known_share) && is_share(rules->core_share) && is_share(rules->quantile) && rules->rim >= LEAST_RIM &&
           rules->rim < MOST_RIM && rules->least_points >= 1.0;
}

static int is_place(const Place *place)
{
    const double *numbers = (const double *)place;
    for (int n = 0; n < PLACE; n++)
        if (!isfinite(numbers[n]))
            return 0;
    return 1;
}

/* What is wrong with the arguments, or NULL. */
static const char *problem_of(const View *view, Py_ssize_t stride, const Grid *boxes)
{
    if (stride < 1)
        return "stride: below 1";
    if (boxes->cols != 6)
        return "boxes: other than 6 numbers each";
    if (!is_place(&view->place))
        return "place: nowhere";
    if (!can_be(view->frame, view->rules->strays))
        return "frame, rules: no size, or strays may be most";
    return are_rules(view->rules) ? NULL : "rules: they cannot be";
}

static const char *look_for(View *view, const Grid *depth_m, Py_ssize_t stride, const Grid *boxes,
                            Thing *things)
{
    const char *problem = view_open(view, depth_m, stride);
    for (Py_ssize_t n = 0; !problem && n < boxes->rows; n++)
        problem = thing_in(view, GRID_ROW(*boxes, double, n), (int32_t)n + 1, things + n);
    free(view->memory);
    return problem;
}

/* What is in each box, as Python has it. */
static PyObject *found_in(View *view, const Grid *depth_m, Py_ssize_t stride, const Grid *boxes)
{
    const char *problem = problem_of(view, stride, boxes);
    if (problem)
        return failed("things", problem);
    Thing *things = calloc((size_t)boxes->rows + 1, sizeof *things);
    if (!things)
        return PyErr_NoMemory();
    Py_BEGIN_ALLOW_THREADS
    problem = look_for(view, depth_m, stride, boxes, things);
    Py_END_ALLOW_THREADS
    PyObject *list = problem ? failed("things", problem) : told(things, boxes->rows);
    for (Py_ssize_t n = 0; n < boxes->rows; n++)
        free(things[n].cells.x);
    free(things);
    return list;
}

PyObject *kernel_things(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {
        {'f', 0, "depth_m"}, {'f', 0, "forward"}, {'f', 0, "left"}, {'f', 0, "up"}};
    Grid grids[4], boxes;
    SegmentRules rules;
    View view = {.rules = &rules};
    Py_ssize_t stride;
    if (count_is("things", count, 9) < 0 || wholes_of(&stride, args + 4, 1) < 0 ||
        numbers_in((double *)&view.place, PLACE, args[6], "place") < 0 ||
        numbers_in((double *)&view.frame, 3, args[7], "frame") < 0 ||
        numbers_in((double *)&rules, SEGMENT_RULES, args[8], "rules") < 0 ||
        grids_open(grids, args, specs, 4) < 0)
        return NULL;
    PyObject *list = NULL;
    if (grid_open(&boxes, args[5], (GridSpec){'d', 0, "boxes"}) == 0) {
        view.forward = grids[1];
        view.left = grids[2];
        view.up = grids[3];
        list = found_in(&view, &grids[0], stride, &boxes);
        grid_close(&boxes);
    }
    grids_close(grids, 4);
    return list;
}
