/* Depth images in RVL (A. D. Wilson, Fast lossless depth image compression, ISS 2017): lengths of a
 * run of zeros and of one of others, then those others, each as its difference from the one before
 * it. A number is nibbles, the lowest three bits first, whose fourth bit tells that more follow. The
 * nibbles fill words of 32 bits, little-endian, from the highest. See packed.py. */
#include "arguments.h"

enum { LONGEST = 10 }; /* nibbles of a number below 2^30: no image has as many pixels */

typedef struct {
    const uint8_t *bytes;
    Py_ssize_t nibble, nibbles; /* the next, of so many */
} Source;

/* The next number; -1 where there is none, or none so small. */
static int32_t number(Source *source)
{
    int32_t value = 0;
    for (int k = 0; k < LONGEST; k++) {
        if (source->nibble >= source->nibbles)
            return -1;
        const Py_ssize_t n = source->nibble++;
        const uint8_t byte = source->bytes[(n & ~(Py_ssize_t)7) / 2 + (3 - (n & 7) / 2)];
        const int32_t nibble = n & 1 ? byte & 0xF : byte >> 4;
        value |= (nibble & 7) << (3 * k);
        if (!(nibble & 8))
            return value;
    }
    return -1;
}

/* So many pixels from `pixel` on, row by row: differences where there is a source, else zeros. */
static int fill(const Grid *out, Py_ssize_t pixel, int32_t length, Source *source, uint16_t *last)
{
    while (length > 0) {
        uint16_t *row = GRID_ROW(*out, uint16_t, pixel / out->cols);
        Py_ssize_t col = pixel % out->cols;
        for (; col < out->cols && length > 0; col++, length--, pixel++) {
            if (!source) {
                row[col] = 0;
                continue;
            }
            const int32_t folded = number(source); /* 0, -1, 1, -2, ... */
            if (folded < 0)
                return 0;
            *last = (uint16_t)(*last + ((folded >> 1) ^ -(folded & 1)));
            row[col] = *last;
        }
    }
    return 1;
}

static int unpack(const Grid *out, Source *source)
{
    const Py_ssize_t pixels = out->rows * out->cols;
    uint16_t last = 0;
    for (Py_ssize_t pixel = 0; pixel < pixels;) {
        const int32_t zeros = number(source);
        if (zeros < 0 || zeros > pixels - pixel)
            return 0;
        fill(out, pixel, zeros, NULL, NULL);
        pixel += zeros;
        const int32_t others = number(source);
        if (others < 0 || others > pixels - pixel || !(zeros || others))
            return 0;
        if (!fill(out, pixel, others, source, &last))
            return 0;
        pixel += others;
    }
    return 1;
}

PyObject *kernel_unpack_rvl(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'H', 1, "readings"}, {'B', 0, "packed"}};
    Grid grids[2];
    int done = 0;
    if (count_is("unpack_rvl", count, 2) < 0 || grids_open(grids, args, specs, 2) < 0)
        return NULL;
    const int one_row = grids[1].rows == 1;
    if (one_row) {
        Source source = {(const uint8_t *)grids[1].at, 0, grids[1].cols / 4 * 8};
        Py_BEGIN_ALLOW_THREADS
        done = unpack(&grids[0], &source);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 2);
    if (!one_row)
        return failed("unpack_rvl", "packed: not one row of bytes");
    return PyBool_FromLong(done);
}
