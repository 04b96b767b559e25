/* Connected components of a depth image, and how large they are. */
#include "labels.h"
#include "objects.h"
#include <string.h>

/* Labels for the time being, the first pixel's the smallest of each component; how many. */
static int32_t first_labels(Surfaces *s, const uint8_t *inside, int32_t *parent)
{
    int32_t next = 1;
    parent[0] = 0;
    for (Py_ssize_t row = 0; row < s->rows; row++) {
        int32_t *label = s->label + row * s->cols;
        const uint8_t *held = inside + row * s->cols;
        int32_t left = 0;
        for (Py_ssize_t col = 0; col < s->cols; col++) {
            if (!held[col]) {
                label[col] = left = 0;
                continue;
            }
            const int32_t above = row ? label[col - s->cols] : 0;
            if (!left && !above) {
                parent[next] = next;
                left = next++;
            } else if (above && left && above != left) {
                left = joined(parent, above, left);
            } else {
                left = above ? above : left;
            }
            label[col] = left;
        }
    }
    return next;
}

/* Final labels for those for the time being. */
static void measure(Surfaces *s, const int32_t *final)
{
    for (Py_ssize_t row = 0; row < s->rows; row++) {
        int32_t *label = s->label + row * s->cols;
        for (Py_ssize_t col = 0; col < s->cols;) {
            const int32_t own = final[label[col]];
            const Py_ssize_t from = col;
            for (; col < s->cols && final[label[col]] == own; col++)
                label[col] = own;
            if (own)
                add_run(s->regions + own, row, from, col);
        }
    }
}

void label_surfaces(Surfaces *s, const uint8_t *inside, int32_t *scratch)
{
    const int32_t count = first_labels(s, inside, scratch);
    s->labels = 1;
    for (int32_t label = 1; label < count; label++) /* what a label stands for comes before it */
        scratch[label] = scratch[label] == label ? s->labels++ : scratch[scratch[label]];
    memset(s->regions, 0, (size_t)s->labels * sizeof *s->regions);
    measure(s, scratch);
}
