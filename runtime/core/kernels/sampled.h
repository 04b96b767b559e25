/* A depth image of which every n-th pixel is used, from the middle of the first n on, and the rays of
 * those pixels. */
#ifndef RFNAV_SAMPLED_H
#define RFNAV_SAMPLED_H

#include "arguments.h"

/* The pixels of a row of the rays: one, and so on every `stride`. */
static inline const float *sampled_row(const Grid *depth, Py_ssize_t stride, Py_ssize_t row)
{
    return GRID_ROW(*depth, float, stride / 2 + row * stride) + stride / 2;
}

/* What is wrong with them; NULL for nothing. */
static inline const char *sampling_problem(const Grid *depth, const Grid *rays, double every)
{
    const Py_ssize_t stride = every >= 1.0 && every < 1e6 ? (Py_ssize_t)every : 0;
    if (!stride)
        return "stride: less than a pixel";
    if ((depth->rows - stride / 2 + stride - 1) / stride != rays->rows ||
        (depth->cols - stride / 2 + stride - 1) / stride != rays->cols)
        return "depth_m: another image than that of the rays";
    return NULL;
}

#endif
