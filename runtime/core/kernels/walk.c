/* A walk over cells, step by step. */
#include "walk.h"
#include <stdlib.h>

const char *walk_begin(Walk *walk, const Grid *passable)
{
    walk->width = passable->cols + 2;
    if (!are_few(passable->rows + 2, walk->width))
        return TOO_MANY_CELLS;
    walk->state = calloc((size_t)(walk->width * (passable->rows + 2)), sizeof *walk->state);
    walk->queue = malloc((size_t)(passable->rows * passable->cols + 1) * sizeof *walk->queue);
    if (!walk->state || !walk->queue)
        return NO_MEMORY;
    for (Py_ssize_t row = 0; row < passable->rows; row++) {
        uint16_t *state = walk->state + (row + 1) * walk->width + 1;
        const uint8_t *open = GRID_ROW(*passable, uint8_t, row);
        for (Py_ssize_t col = 0; col < passable->cols; col++)
            state[col] = open[col] ? OPEN : CLOSED;
    }
    return NULL;
}

void walk_end(Walk *walk)
{
    free(walk->state);
    free(walk->queue);
}

void walk_start(Walk *walk, Py_ssize_t row, Py_ssize_t col)
{
    const Py_ssize_t cell = (row + 1) * walk->width + 1 + col;
    if (walk->state[cell] == 1)
        return;
    walk->state[cell] = 1;
    walk->queue[walk->count++] = (int32_t)cell;
}

static inline void reach(Walk *walk, Py_ssize_t cell, uint16_t step)
{
    if (walk->state[cell] == OPEN) {
        walk->state[cell] = step;
        walk->queue[walk->count++] = (int32_t)cell;
    }
}

void walk_on(Walk *walk, long limit)
{
    const Py_ssize_t w = walk->width;
    Py_ssize_t before = 0, last = 0; /* where the queue has the last step but one, and the last */
    for (long step = 1; step <= limit; step++) {
        const Py_ssize_t end = walk->count;
        const uint16_t mark = (uint16_t)(step + 1);
        if (step % 2) {
            for (Py_ssize_t n = last; n < end; n++) {
                const Py_ssize_t cell = walk->queue[n];
                reach(walk, cell - w, mark), reach(walk, cell - 1, mark);
                reach(walk, cell + 1, mark), reach(walk, cell + w, mark);
            }
        } else { /* the step before the last went to the sides alone */
            for (Py_ssize_t n = before; n < end; n++) {
                const Py_ssize_t cell = walk->queue[n];
                for (Py_ssize_t at = cell - w; at <= cell + w; at += w)
                    reach(walk, at - 1, mark), reach(walk, at, mark), reach(walk, at + 1, mark);
            }
        }
        if (walk->count == end)
            return;
        before = last;
        last = end;
    }
}
