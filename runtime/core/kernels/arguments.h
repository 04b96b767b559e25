/* What kernels are given, and how they tell what is wrong with it. */
#ifndef RFNAV_ARGUMENTS_H
#define RFNAV_ARGUMENTS_H

#include "kernels.h"
#include <stdint.h>

/* A 2-D array whose rows are contiguous; rows may lie apart, as in a window of a larger array. */
typedef struct {
    Py_buffer view;
    char *at;
    Py_ssize_t rows, cols, stride; /* stride in bytes, from row to row */
} Grid;

/* A row of it. */
#define GRID_ROW(grid, type, row) ((type *)((grid).at + (row) * (grid).stride))

/* Of a grid: 64 bits hold the bytes of whatever is made of its cells, or of rows of them. */
enum { LONGEST_SIDE = 1 << 28 };

/* What an array's items are: a struct module code such as 'd', 'f' or 'B', or one of these. */
enum { BYTES = 0, BYTES_OR_FLOATS = 'S' };

/* How an argument that is an array must be. */
typedef struct {
    char kind;
    int writable;
    const char *name;
} GridSpec;

/* Opens an array. Returns -1 with TypeError or ValueError set, which name the argument. */
int grid_open(Grid *grid, PyObject *array, GridSpec spec);
void grid_close(Grid *grid);

/* Opens several arrays, or none of them. */
int grids_open(Grid *grids, PyObject *const *args, const GridSpec *specs, int count);
void grids_close(Grid *grids, int count);

/* -1 with ValueError set where grids from the first on are not all of one shape. */
int grids_alike(const Grid *grids, const GridSpec *specs, int count);

/* Opens points (N, 2) m, at least one. */
int points_open(Grid *grid, PyObject *array, const char *name);

/* Read arguments, up to the first that is none; -1 with TypeError or OverflowError set. */
int numbers_of(double *numbers, PyObject *const *args, int count);
int wholes_of(Py_ssize_t *wholes, PyObject *const *args, int count);

/* Reads a tuple of so many numbers; -1 with TypeError set, which names the argument. */
int numbers_in(double *numbers, Py_ssize_t count, PyObject *tuple, const char *name);

/* -1 with TypeError set where the count of arguments is another. */
int count_is(const char *kernel, Py_ssize_t count, Py_ssize_t wanted);

/* Problems that are none of the arguments' own: there is no memory; there would be more cells than
 * an int32_t numbers. */
extern const char NO_MEMORY[], TOO_MANY_CELLS[];

/* Sets MemoryError or ValueError; NULL. */
PyObject *failed(const char *kernel, const char *problem);

/* Whether an int32_t numbers so many rows of so many cells, none of them below 0. */
static inline int are_few(Py_ssize_t rows, Py_ssize_t cols)
{
    return cols == 0 || rows <= INT32_MAX / cols;
}

static inline double lesser(double a, double b) { return a < b ? a : b; }
static inline double greater(double a, double b) { return a > b ? a : b; }

#endif
