/* The things in a detector's boxes: which pixels are of each, and where in the map they are. */
#include "objects_view.h"
#include <math.h>
#include <stdlib.h>

typedef struct {
    double near_m, x, y, z, low, high;
    Footprint cells; /* of which arrays are its own */
} Thing;

int numbers_open(double *into, Py_ssize_t count, PyObject *tuple, const char *name)
{
    if (!PyTuple_Check(tuple) || PyTuple_Size(tuple) != count) {
        PyErr_Format(PyExc_TypeError, "%s: not a tuple of %zd numbers", name, count);
        return -1;
    }
    for (Py_ssize_t n = 0; n < count; n++)
        into[n] = PyFloat_AsDouble(PyTuple_GetItem(tuple, n));
    return PyErr_Occurred() ? -1 : 0;
}

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
    const Rules *rules = view->rules;
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

/* The middle of n points, their height without strays at the rim, and the cells under them. */
static const char *measured(const View *view, Thing *thing, const double *x, const double *y,
                            const double *z, size_t n, double *scratch)
{
    double *cells = malloc(2 * n * sizeof *cells), found[4];
    if (!cells)
        return "out of memory";
    thing->cells = (Footprint){cells, cells + n, 0};
    const Points points = {x, y, n, range_of(x, n), range_of(y, n)};
    const char *problem =
        footprint(&view->frame, &points, &thing->cells, (int32_t *)(void *)scratch);
    if (problem)
        return problem;
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
        return "a box that begins before the image";
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

/* Opens the arguments that are grids; how many of them, fewer than all with an error set. */
static int grids_open(Grid *const *grids, PyObject *const *args)
{
    static const struct {
        const char *name;
        int at;
        char kind;
    } each[5] = {{"depth_m", 0, 'f'}, {"forward", 1, 'f'}, {"left", 2, 'f'}, {"up", 3, 'f'},
                 {"boxes", 5, 'd'}};
    int opened = 0;
    while (opened < 5 && grid_open(grids[opened], args[each[opened].at], each[opened].kind, 0,
                                   each[opened].name) == 0)
        opened++;
    return opened;
}

static int is_share(double value) { return value >= 0.0 && value <= 1.0; }

static const char *look_for(View *view, const Grid *depth_m, Py_ssize_t stride, const Grid *boxes,
                            Thing *things)
{
    const Rules *rules = view->rules;
    if (!can_be(view->frame, rules->strays) || !is_share(rules->core_share) ||
        !is_share(rules->quantile) || !(rules->rim >= 1.0 && rules->least_points >= 1.0))
        return "a frame or rules that cannot be";
    const char *problem = view_open(view, depth_m, stride);
    for (Py_ssize_t n = 0; !problem && n < boxes->rows; n++)
        problem = thing_in(view, GRID_ROW(*boxes, double, n), (int32_t)n + 1, things + n);
    free(view->memory);
    return problem;
}

PyObject *kernel_things(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    Grid depth_m, boxes;
    Rules rules;
    View view = {.rules = &rules};
    Grid *const grids[5] = {&depth_m, &view.forward, &view.left, &view.up, &boxes};
    (void)module;
    if (count != 9)
        return PyErr_Format(PyExc_TypeError, "things takes 9 arguments, not %zd", count);
    const Py_ssize_t stride = PyNumber_AsSsize_t(args[4], PyExc_OverflowError);
    if (PyErr_Occurred() || numbers_open((double *)&view.place, PLACE, args[6], "place") < 0 ||
        numbers_open((double *)&view.frame, 3, args[7], "frame") < 0 ||
        numbers_open((double *)&rules, RULES, args[8], "rules") < 0)
        return NULL;
    PyObject *list = NULL;
    const int opened = grids_open(grids, args);
    Thing *things = opened == 5 ? calloc((size_t)boxes.rows + 1, sizeof *things) : NULL;
    if (opened == 5) {
        const char *problem = "a stride below 1, boxes of other than 6 numbers, or no memory";
        if (things && stride > 0 && boxes.cols == 6) {
            Py_BEGIN_ALLOW_THREADS
            problem = look_for(&view, &depth_m, stride, &boxes, things);
            Py_END_ALLOW_THREADS
        }
        if (problem)
            PyErr_Format(PyExc_ValueError, "things: %s", problem);
        else
            list = told(things, boxes.rows);
        for (Py_ssize_t n = 0; things && n < boxes.rows; n++)
            free(things[n].cells.x);
        free(things);
    }
    for (int n = 0; n < opened; n++)
        grid_close(grids[n]);
    return list;
}
