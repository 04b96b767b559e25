/* Labels of sets that turn out to be one: each has a parent, itself at the root, and the root of a
 * set is its least label. */
#ifndef RFNAV_LABELS_H
#define RFNAV_LABELS_H

#include "kernels.h"
#include <stdint.h>

static inline int32_t root_of(int32_t *parent, int32_t label)
{
    while (parent[label] != label) {
        parent[label] = parent[parent[label]]; /* the next way up is half as long */
        label = parent[label];
    }
    return label;
}

/* Makes the sets of two labels one; its root. */
static inline int32_t joined(int32_t *parent, int32_t a, int32_t b)
{
    a = root_of(parent, a);
    b = root_of(parent, b);
    const int32_t least = a < b ? a : b;
    parent[a] = parent[b] = least;
    return least;
}

#endif
