/* How sharp an image is. */
#include "arguments.h"
#include <stdlib.h>

enum { CHANNELS = 3 };
enum { MOST_HIGH = 257 /* rows that a sum in 16 bits holds */, MOST_COLS = 1 << 20 };

/* To the nearest, halves to the even one: what is below 2^22 has no fraction left beside it. */
static inline int32_t rounded(float value)
{
    const float whole = 12582912.0f;
    return (int32_t)((value + whole) - whole);
}

/* Sums of rows, by column; two at a time, for the sums to be read and written less. */
static void sum_rows(const Grid *rgb, Py_ssize_t first, Py_ssize_t high, uint16_t *restrict sums)
{
    const Py_ssize_t end = first + high, n = rgb->cols;
    Py_ssize_t row = first + high % 2;
    const uint8_t *restrict from = GRID_ROW(*rgb, uint8_t, first);
    for (Py_ssize_t col = 0; col < n; col++)
        sums[col] = high % 2 ? from[col] : 0;
    for (; row < end; row += 2) {
        const uint8_t *restrict one = GRID_ROW(*rgb, uint8_t, row);
        const uint8_t *restrict other = GRID_ROW(*rgb, uint8_t, row + 1);
        for (Py_ssize_t col = 0; col < n; col++)
            sums[col] = (uint16_t)(sums[col] + one[col] + other[col]);
    }
}

/* Sums of blocks of a row, each so many pixels wide. */
static void sum_blocks(const uint16_t *restrict sums, Py_ssize_t wide, int32_t *restrict totals,
                       Py_ssize_t cols)
{
    for (Py_ssize_t n = 0; n < cols * CHANNELS; n++)
        totals[n] = 0;
    for (Py_ssize_t k = 0; k < wide; k++) {
        const uint16_t *from = sums + k * CHANNELS;
        for (Py_ssize_t col = 0; col < cols; col++, from += wide * CHANNELS)
            for (int channel = 0; channel < CHANNELS; channel++)
                totals[col * CHANNELS + channel] += from[channel];
    }
}

/* Means of blocks, rounded as OpenCV's area interpolation does, in grey by OpenCV's weights of
 * red, green and blue. */
static void grey_row(int32_t *restrict totals, Py_ssize_t high, Py_ssize_t wide,
                     uint8_t *restrict grey, Py_ssize_t cols)
{
    const float share = 1.0f / (float)(high * wide);
    if (high == 2 && wide == 2) { /* there OpenCV rounds halves up */
        for (Py_ssize_t n = 0; n < cols * CHANNELS; n++)
            totals[n] = (totals[n] + 2) >> 2;
    } else {
        for (Py_ssize_t n = 0; n < cols * CHANNELS; n++)
            totals[n] = rounded((float)totals[n] * share);
    }
    for (Py_ssize_t col = 0; col < cols; col++) {
        const int32_t *rgb = totals + col * CHANNELS;
        grey[col] = (uint8_t)((rgb[0] * 9798 + rgb[1] * 19235 + rgb[2] * 3735 + (1 << 14)) >> 15);
    }
}

static inline int32_t mirrored(int32_t at, int32_t size)
{
    return size == 1 ? 0 : at < 0 ? -at : at < size ? at : 2 * size - 2 - at;
}

/* The mean of the absolute Laplacian, whose image goes on as in a mirror. */
static double mean_edge(const uint8_t *grey, int32_t rows, int32_t cols)
{
    int64_t total = 0;
    for (int32_t row = 0; row < rows; row++) {
        const uint8_t *here = grey + row * cols;
        const uint8_t *above = grey + mirrored(row - 1, rows) * cols;
        const uint8_t *below = grey + mirrored(row + 1, rows) * cols;
        int32_t sum = abs(above[0] + below[0] + 2 * here[mirrored(1, cols)] - 4 * here[0]);
        for (int32_t col = 1; col < cols - 1; col++)
            sum += abs(above[col] + below[col] + here[col - 1] + here[col + 1] - 4 * here[col]);
        const int32_t last = cols - 1;
        if (last)
            sum += abs(above[last] + below[last] + 2 * here[last - 1] - 4 * here[last]);
        total += sum;
    }
    return (double)total / ((double)rows * (double)cols);
}

static const char *sharpness(const Grid *rgb, Py_ssize_t rows, Py_ssize_t cols, double *found)
{
    if (rows < 1 || cols < 1 || rows > INT32_MAX / 8 / cols || rgb->rows % rows ||
        rgb->cols % (cols * CHANNELS) || !rgb->rows || !rgb->cols)
        return "an image that is no whole number of times the smaller one";
    const Py_ssize_t high = rgb->rows / rows, wide = rgb->cols / cols / CHANNELS;
    if (high > MOST_HIGH || wide > MOST_HIGH || cols > MOST_COLS)
        return "an image that is too large";
    uint16_t *sums = malloc((size_t)rgb->cols * sizeof *sums);
    uint8_t *grey = malloc((size_t)(rows * cols));
    int32_t *totals = malloc((size_t)(cols * CHANNELS) * sizeof *totals);
    const int enough = sums && grey && totals;
    for (Py_ssize_t row = 0; enough && row < rows; row++) {
        sum_rows(rgb, row * high, high, sums);
        sum_blocks(sums, wide, totals, cols);
        grey_row(totals, high, wide, grey + row * cols, cols);
    }
    if (enough)
        *found = mean_edge(grey, (int32_t)rows, (int32_t)cols);
    free(totals);
    free(grey);
    free(sums);
    return enough ? NULL : NO_MEMORY;
}

PyObject *kernel_sharpness(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    Grid rgb;
    Py_ssize_t size[2];
    double found = 0.0;
    if (count_is("sharpness", count, 3) < 0 || wholes_of(size, args + 1, 2) < 0 ||
        grid_open(&rgb, args[0], (GridSpec){'B', 0, "rgb"}) < 0)
        return NULL;
    const char *problem;
    Py_BEGIN_ALLOW_THREADS
    problem = sharpness(&rgb, size[0], size[1], &found);
    Py_END_ALLOW_THREADS
    grid_close(&rgb);
    return problem ? failed("sharpness", problem) : PyFloat_FromDouble(found);
}
