/* Where the instances are: which of them may be meant by a thing, and which are in plain view. */
#include "objects.h"
#include <math.h>
#include <stdlib.h>

/* Rows of the table of places, by instance. */
enum { MIDDLE_X, MIDDLE_Y, MIDDLE_Z, LEFT, BELOW, RIGHT, ABOVE, TABLE_ROWS };

static inline double outside(double at, double low, double high)
{
    const double gap = at < low ? low - at : at - high;
    return gap > 0.0 ? gap : 0.0;
}

static inline double square(double dx, double dy) { return dx * dx + dy * dy; }

/* From the thing's middle to an instance's box or from its box to that one's middle, which need
 * not lie in it, m²; the thing is its middle and its box. */
static double least_square(const double *const *at, Py_ssize_t n, const double *thing)
{
    const double x = thing[0], y = thing[1], middle_x = at[MIDDLE_X][n], middle_y = at[MIDDLE_Y][n];
    const double to_box = square(outside(x, at[LEFT][n], at[RIGHT][n]),
                                 outside(y, at[BELOW][n], at[ABOVE][n]));
    const double from_box = square(outside(middle_x, thing[2], thing[4]),
                                   outside(middle_y, thing[3], thing[5]));
    const double apart = square(middle_x - x, middle_y - y);
    const double least = to_box < from_box ? to_box : from_box;
    return least < apart ? least : apart;
}

/* By so much the last bits may differ from those of other ways to compute a distance. */
static const double LESS = 1.0 - 1e-12;

typedef struct {
    double square;
    Py_ssize_t place;
} Near;

/* The ends of a box round cells: left, below, right, above. */
static void ends_of(const Grid *cells, double *box)
{
    const double *first = GRID_ROW(*cells, double, 0);
    box[0] = box[2] = first[0];
    box[1] = box[3] = first[1];
    for (Py_ssize_t n = 1; n < cells->rows; n++) {
        const double *xy = GRID_ROW(*cells, double, n);
        box[0] = xy[0] < box[0] ? xy[0] : box[0];
        box[1] = xy[1] < box[1] ? xy[1] : box[1];
        box[2] = xy[0] > box[2] ? xy[0] : box[2];
        box[3] = xy[1] > box[3] ? xy[1] : box[3];
    }
}

PyObject *kernel_cells_extent(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid cells;
    double box[4];
    if (count_is("cells_extent", count, 1) < 0 || points_open(&cells, args[0], "cells") < 0)
        return NULL;
    Py_BEGIN_ALLOW_THREADS
    ends_of(&cells, box);
    Py_END_ALLOW_THREADS
    grid_close(&cells);
    return Py_BuildValue("(dd)", box[2] - box[0], box[3] - box[1]);
}

static int nearest_first(const void *a, const void *b)
{
    const Near *one = a, *other = b;
    if (one->square != other->square)
        return one->square < other->square ? -1 : 1;
    return (one->place > other->place) - (one->place < other->place);
}

/* Whether all of a place is so low, or so high, along an axis. */
static inline int beyond(const double *middle, const double *low, const double *high, Py_ssize_t n,
                         double from, double to)
{
    return (middle[n] < from && high[n] < from) || (middle[n] > to && low[n] > to);
}

/* The thing is its middle and the ends of its box. */
static Py_ssize_t find_near(const Grid *table, const double *thing, double within_m, Near *found)
{
    const double *at[TABLE_ROWS], most = within_m * within_m;
    const double left = fmin(thing[0], thing[2]) - within_m;
    const double below = fmin(thing[1], thing[3]) - within_m;
    const double right = fmax(thing[0], thing[4]) + within_m;
    const double above = fmax(thing[1], thing[5]) + within_m;
    for (Py_ssize_t row = 0; row < TABLE_ROWS; row++)
        at[row] = GRID_ROW(*table, double, row);
    Py_ssize_t count = 0;
    for (Py_ssize_t n = 0; n < table->cols; n++) {
        if (beyond(at[MIDDLE_X], at[LEFT], at[RIGHT], n, left, right) ||
            beyond(at[MIDDLE_Y], at[BELOW], at[ABOVE], n, below, above))
            continue;
        const double least = least_square(at, n, thing);
        if (least <= most)
            found[count++] = (Near){least, n};
    }
    qsort(found, (size_t)count, sizeof *found, nearest_first);
    return count;
}

static int table_open(Grid *table, PyObject *array, int writable)
{
    if (grid_open(table, array, (GridSpec){'d', writable, "places"}) < 0)
        return -1;
    if (table->rows == TABLE_ROWS)
        return 0;
    PyErr_Format(PyExc_ValueError, "places: %zd rows, not %d", table->rows, TABLE_ROWS);
    grid_close(table);
    return -1;
}

/* The columns that have a name, in a list of such. */
static int places_open(Grid *table, PyObject *array, PyObject *names)
{
    if (!PyList_Check(names)) {
        PyErr_SetString(PyExc_TypeError, "names: not a list");
        return -1;
    }
    if (table_open(table, array, 0) < 0)
        return -1;
    if (PyList_Size(names) <= table->cols) {
        table->cols = PyList_Size(names);
        return 0;
    }
    PyErr_Format(PyExc_ValueError, "names: more than %zd places", table->cols);
    grid_close(table);
    return -1;
}

PyObject *kernel_put_place(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid table, cells;
    double place[TABLE_ROWS];
    Py_ssize_t column;
    if (count_is("put_place", count, 5) < 0 || wholes_of(&column, args + 1, 1) < 0 ||
        numbers_in(place, 2, args[2], "xy") < 0 || numbers_of(place + MIDDLE_Z, args + 3, 1) < 0 ||
        points_open(&cells, args[4], "cells") < 0)
        return NULL;
    if (table_open(&table, args[0], 1) < 0) {
        grid_close(&cells);
        return NULL;
    }
    const int there = column >= 0 && column < table.cols;
    Py_BEGIN_ALLOW_THREADS
    ends_of(&cells, place + LEFT);
    for (Py_ssize_t row = 0; there && row < TABLE_ROWS; row++)
        GRID_ROW(table, double, row)[column] = place[row];
    Py_END_ALLOW_THREADS
    grid_close(&table);
    grid_close(&cells);
    if (!there)
        return PyErr_Format(PyExc_IndexError, "places: there is no column %zd", column);
    Py_RETURN_NONE;
}

/* (how near at least, what the place is called) of each. */
static PyObject *gaps_told(const Near *found, Py_ssize_t count, PyObject *names)
{
    PyObject *list = found ? PyList_New(count) : PyErr_NoMemory();
    for (Py_ssize_t n = 0; list && n < count; n++) {
        PyObject *one = Py_BuildValue("(dO)", LESS * sqrt(found[n].square),
                                      PyList_GetItem(names, found[n].place));
        if (!one || PyList_SetItem(list, n, one) < 0)
            Py_CLEAR(list);
    }
    return list;
}

PyObject *kernel_near_places(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid table, cells;
    double thing[6], within_m;
    if (count_is("near_places", count, 5) < 0 || numbers_of(&within_m, args + 4, 1) < 0 ||
        numbers_in(thing, 2, args[2], "xy") < 0 ||
        points_open(&cells, args[3], "cells") < 0)
        return NULL;
    if (places_open(&table, args[0], args[1]) < 0) {
        grid_close(&cells);
        return NULL;
    }
    Near *found = malloc(((size_t)table.cols + 1) * sizeof *found);
    Py_ssize_t near = 0;
    Py_BEGIN_ALLOW_THREADS
    ends_of(&cells, thing + 2);
    if (found)
        near = find_near(&table, thing, within_m, found);
    Py_END_ALLOW_THREADS
    grid_close(&table);
    grid_close(&cells);
    PyObject *list = gaps_told(found, near, args[1]);
    free(found);
    return list;
}

/* A camera, and what of its image counts. */
typedef struct {
    double x, y, cos, sin;          /* of the base in the map's frame */
    double camera_x, camera_y, camera_z;
    double turn[9];                 /* from the base's frame to the optical one, by rows */
    double fx, fy, cx, cy;          /* px */
    double near_m, far_m, reach_m;  /* along its axis, and of the base */
    double margin_x, margin_y;      /* shares of the image's sides that do not count */
    double behind_m;                /* so much nearer may be what is seen there */
} Lens;
enum { LENS = sizeof(Lens) / sizeof(double), AROUND_PX = 4 };

typedef struct {
    double u, v, z;
} Pixel;

static Pixel projected(const Lens *lens, double x_m, double y_m, double z_m)
{
    const double dx = x_m - lens->x, dy = y_m - lens->y;
    const double x = lens->cos * dx + lens->sin * dy - lens->camera_x;
    const double y = lens->cos * dy - lens->sin * dx - lens->camera_y;
    const double z = z_m - lens->camera_z, *t = lens->turn;
    const double right = x * t[0] + y * t[3] + z * t[6];
    const double down = x * t[1] + y * t[4] + z * t[7];
    const double ahead = x * t[2] + y * t[5] + z * t[8];
    return (Pixel){right / ahead * lens->fx + lens->cx - 0.5,
                   down / ahead * lens->fy + lens->cy - 0.5, ahead};
}

static inline Py_ssize_t clipped(Py_ssize_t at, Py_ssize_t size)
{
    return at < 0 ? 0 : at < size ? at : size - 1;
}

/* The median of what is known round a pixel, m; -inf where nothing is. */
static float depth_at(const Grid *depth_m, Py_ssize_t row, Py_ssize_t col)
{
    double known[(2 * AROUND_PX + 1) * (2 * AROUND_PX + 1)];
    double scratch[sizeof known / sizeof *known];
    size_t count = 0;
    for (Py_ssize_t r = row - AROUND_PX; r <= row + AROUND_PX; r++) {
        const float *depth = GRID_ROW(*depth_m, float, clipped(r, depth_m->rows));
        for (Py_ssize_t c = col - AROUND_PX; c <= col + AROUND_PX; c++) {
            const float here = depth[clipped(c, depth_m->cols)];
            if (here > 0.0f)
                known[count++] = (double)here;
        }
    }
    if (!count)
        return -INFINITY;
    const size_t ranks[2] = {(count - 1) / 2, count / 2};
    double found[2];
    at_ranks(known, count, ranks, 2, found, scratch);
    return ((float)found[0] + (float)found[1]) / 2.0f;
}

/* Notes the places that are in the image, not too near its sides, in range, and not hidden. */
static Py_ssize_t find_shown(const Grid *table, const Grid *depth_m, const Lens *lens,
                             Py_ssize_t *found)
{
    const double *x = GRID_ROW(*table, double, MIDDLE_X), *y = GRID_ROW(*table, double, MIDDLE_Y);
    const double *z = GRID_ROW(*table, double, MIDDLE_Z);
    const double width = (double)depth_m->cols, height = (double)depth_m->rows;
    const double low_x = lens->margin_x * width, high_x = (1.0 - lens->margin_x) * width;
    const double low_y = lens->margin_y * height, high_y = (1.0 - lens->margin_y) * height;
    Py_ssize_t count = 0;
    for (Py_ssize_t n = 0; n < table->cols; n++) {
        if (square(x[n] - lens->x, y[n] - lens->y) > lens->reach_m * lens->reach_m)
            continue;
        const Pixel at = projected(lens, x[n], y[n], z[n]);
        if (!(at.z >= lens->near_m && at.z <= lens->far_m && low_x < at.u && at.u < high_x &&
              low_y < at.v && at.v < high_y))
            continue;
        if ((double)depth_at(depth_m, (Py_ssize_t)at.v, (Py_ssize_t)at.u) >= at.z - lens->behind_m)
            found[count++] = n;
    }
    return count;
}

PyObject *kernel_in_plain_view(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid table, depth_m;
    Lens lens;
    if (count_is("in_plain_view", count, 4) < 0 ||
        numbers_in((double *)&lens, LENS, args[3], "lens") < 0)
        return NULL;
    if (!(lens.margin_x >= 0.0 && lens.margin_y >= 0.0))
        return failed("in_plain_view", "lens: a margin below 0");
    if (grid_open(&depth_m, args[2], (GridSpec){'f', 0, "depth_m"}) < 0)
        return NULL;
    if (places_open(&table, args[0], args[1]) < 0) {
        grid_close(&depth_m);
        return NULL;
    }
    Py_ssize_t *found = malloc(((size_t)table.cols + 1) * sizeof *found), shown = 0;
    Py_BEGIN_ALLOW_THREADS
    if (found)
        shown = find_shown(&table, &depth_m, &lens, found);
    Py_END_ALLOW_THREADS
    grid_close(&depth_m);
    grid_close(&table);
    PyObject *list = found ? PyList_New(shown) : PyErr_NoMemory();
    for (Py_ssize_t n = 0; list && n < shown; n++) {
        PyObject *name = PyList_GetItem(args[1], found[n]);
        if (!name || PyList_SetItem(list, n, Py_NewRef(name)) < 0)
            Py_CLEAR(list);
    }
    free(found);
    return list;
}
