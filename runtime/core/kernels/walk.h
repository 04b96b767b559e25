/* A walk over cells, step by step. */
#ifndef RFNAV_WALK_H
#define RFNAV_WALK_H
#include "arguments.h"

/* Of a cell; else one more than the step that reached it. */
enum { CLOSED = 0, OPEN = 0xFFFF };

typedef struct {
    uint16_t *state; /* padded by a closed cell on each side */
    Py_ssize_t width;
    int32_t *queue; /* the cells that were reached, in order */
    Py_ssize_t count;
} Walk;

/* Begins a walk of no steps, from nowhere, over what is passable. Returns what is wrong, or NULL;
 * it is to be ended either way. */
const char *walk_begin(Walk *walk, const Grid *passable);
void walk_end(Walk *walk);

/* One more cell to start at, passable or not. */
void walk_start(Walk *walk, Py_ssize_t row, Py_ssize_t col);

/* Odd steps lead to the four cells beside, even ones to the eight around: an octagon in all. The
 * walk ends with the first step that reaches nothing. */
void walk_on(Walk *walk, long limit);

static inline int is_reached(uint16_t state) { return state != CLOSED && state != OPEN; }

#endif
