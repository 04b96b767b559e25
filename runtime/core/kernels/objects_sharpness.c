/* How sharp an image is. */
#include "objects.h"
#include <stdlib.h>

enum { CHANNELS = 3, MOST_HIGH = 257 /* rows that a sum in 16 bits holds */ };

/* To the nearest, halves to the even one: what is below 2^22 has no fraction left beside it. */
static inline uint32_t rounded(float value)
{
    const float whole = 12582912.0f;
    return (uint32_t)((value + whole) - whole);
}

/* A row of the smaller image in grey: means of blocks, rounded as OpenCV's area interpolation
 * does, then OpenCV's weights of red, green and blue. */
static void grey_row(const Grid *rgb, Py_ssize_t first, Py_ssize_t high, Py_ssize_t wide,
                     uint16_t *restrict sums, uint8_t *restrict grey, Py_ssize_t cols)
{
    const uint8_t *restrict from = GRID_ROW(*rgb, uint8_t, first);
    for (Py_ssize_t n = 0; n < rgb->cols; n++)
        sums[n] = from[n];
    for (Py_ssize_t r = first + 1; r < first + high; r++) {
        from = GRID_ROW(*rgb, uint8_t, r);
        for (Py_ssize_t n = 0; n < rgb->cols; n++)
            sums[n] = (uint16_t)(sums[n] + from[n]);
    }
    const float share = 1.0f / (float)(high * wide);
    const int two = high == 2 && wide == 2; /* there OpenCV rounds halves up */
    for (Py_ssize_t col = 0; col < cols; col++) {
        uint32_t total[CHANNELS] = {0};
        const uint16_t *block = sums + col * wide * CHANNELS;
        for (Py_ssize_t n = 0; n < wide; n++)
            for (int channel = 0; channel < CHANNELS; channel++)
                total[channel] += block[n * CHANNELS + channel];
        for (int channel = 0; channel < CHANNELS; channel++)
            total[channel] = two ? (total[channel] + 2) >> 2
                                 : rounded((float)total[channel] * share);
        grey[col] = (uint8_t)((total[0] * 9798 + total[1] * 19235 + total[2] * 3735 + (1 << 14)) >>
                              15);
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
    if (high > MOST_HIGH || wide > MOST_HIGH)
        return "an image that is too large";
    uint16_t *sums = malloc((size_t)rgb->cols * sizeof *sums);
    uint8_t *grey = malloc((size_t)(rows * cols));
    const int enough = sums && grey;
    for (Py_ssize_t row = 0; enough && row < rows; row++)
        grey_row(rgb, row * high, high, wide, sums, grey + row * cols, cols);
    if (enough)
        *found = mean_edge(grey, (int32_t)rows, (int32_t)cols);
    free(grey);
    free(sums);
    return enough ? NULL : "out of memory";
}

PyObject *kernel_sharpness(PyObject *module, PyObject *const *args, Py_ssize_t count)
{
    Grid rgb;
    double found = 0.0;
    (void)module;
    if (count != 3)
        return PyErr_Format(PyExc_TypeError, "sharpness takes 3 arguments, not %zd", count);
    const Py_ssize_t rows = PyNumber_AsSsize_t(args[1], PyExc_OverflowError);
    const Py_ssize_t cols = PyNumber_AsSsize_t(args[2], PyExc_OverflowError);
    if (PyErr_Occurred() || grid_open(&rgb, args[0], 'B', 0, "rgb") < 0)
        return NULL;
    const char *problem;
    Py_BEGIN_ALLOW_THREADS
    problem = sharpness(&rgb, rows, cols, &found);
    Py_END_ALLOW_THREADS
    grid_close(&rgb);
    if (problem)
        return PyErr_Format(PyExc_ValueError, "sharpness: %s", problem);
    return PyFloat_FromDouble(found);
}
