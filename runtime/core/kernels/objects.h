/* What the kernels of the semantic map share. */
#ifndef RFNAV_OBJECTS_H
#define RFNAV_OBJECTS_H

#include "arguments.h"
#include <stddef.h>

/* A grid's corner and the length of its cells, m. */
typedef struct {
    double x0_m, y0_m, cell_m;
} Frame;

/* Which cells under a thing are not of it: farther from their middle than so many times their
 * median distance from it, and than so far. */
typedef struct {
    double times, least_m;
} Strays;

/* Centres of cells in scan order, m. */
typedef struct {
    double *x, *y;
    size_t count;
} Footprint;

/* Some pixels of an image, and the rectangle round them, its last row and column included. */
typedef struct {
    int32_t pixels, top, bottom, left, right;
} Region;

static inline void add_run(Region *region, Py_ssize_t row, Py_ssize_t from, Py_ssize_t end)
{
    const int32_t at = (int32_t)row, left = (int32_t)from, right = (int32_t)end - 1;
    if (!region->pixels)
        *region = (Region){0, at, at, left, right};
    region->pixels += right - left + 1;
    region->bottom = at;
    region->left = left < region->left ? left : region->left;
    region->right = right > region->right ? right : region->right;
}

/* Pixels of the rectangle. */
static inline double span_of(const Region *r)
{
    return (double)(r->bottom - r->top + 1) * (double)(r->right - r->left + 1);
}

/* What hangs together in an image: labels of its pixels, 0 for what is of no surface, and a region
 * of each other label. */
typedef struct {
    Py_ssize_t rows, cols;
    int32_t *label;
    Region *regions;
    int32_t labels;
} Surfaces;

/* Whether cells have the size of some on a map, and strays are no more than half. */
static inline int can_be(Frame frame, Strays strays)
{
    return frame.cell_m > 0.0 && frame.cell_m < 1e9 && strays.times >= 1.0 &&
           strays.least_m >= 0.0;
}

typedef struct {
    double low, high;
} Range;

/* Of n values, at least one. */
Range range_of(const double *values, size_t n);
/* The values at up to 4 ascending ranks of n values; the scratch holds n. */
void at_ranks(const double *values, size_t n, const size_t *ranks, size_t count, double *found,
              double *scratch);
double median(const double *values, size_t n, double *scratch);
/* The same where the range is known. */
void ranked(const double *values, size_t n, Range range, const size_t *ranks, size_t count,
            double *found, double *scratch);
double median_in(const double *values, size_t n, Range range, double *scratch);

/* n points and their ranges, m. */
typedef struct {
    const double *x, *y;
    size_t n;
    Range across, along;
} Points;

/* Of points: they are nowhere on a map. */
extern const char NOWHERE[];

/* The cells under points, each once, in scan order. Room for as many in `into`, twice as many in
 * the scratch. Returns what is wrong, or NULL. */
const char *footprint(const Frame *frame, const Points *points, Footprint *into, int32_t *scratch);
/* Leaves strays out. The scratch holds 2 of each cell. */
void without_strays(Footprint *cells, Strays strays, double *scratch);
/* Bytes of (N, 2) numbers. */
PyObject *packed(const Footprint *cells);

/* Labels an image by 4-neighbours whose `inside` is not 0, in the order of their first pixels.
 * There is room for a label and a region of each pixel and one more, and for as many numbers in
 * the scratch. */
void label_surfaces(Surfaces *surfaces, const uint8_t *inside, int32_t *scratch);

#endif
