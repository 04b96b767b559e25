/* Fast marching: the arrival times of a front that starts at some cells and moves at each cell's
 * speed, by the first-order upwind scheme of the eikonal equation.
 *
 * Cells wait in buckets by arrival, half a cell's fastest crossing wide, and not in order within
 * one; a cell is computed again whenever a neighbour comes nearer. So, whatever the order, what
 * comes out is the scheme's one solution within rounding: where the neighbours' gap is about the
 * crossing, one that comes nearer may give an arrival that is later by an ulp. A front that goes on
 * from known arrivals ends within a few ulps of one from the start, not always at the same bits. */
#include "arguments.h"
#include <math.h>
#include <stdlib.h>

typedef struct {
    int32_t *cells;
    size_t count, room;
} Bucket;

typedef struct {
    double *arrival;    /* padded by a cell on each side, inf there */
    double *crossing;   /* time to cross a cell, 0 where nothing moves */
    Py_ssize_t width;   /* of a padded row */
    double limit, per_bucket;
    Py_ssize_t until;   /* the cell at whose arrival the limit is known, 0 for none */
    double beyond;      /* it is so much later */
    Bucket *ring;
    int64_t ring_size;  /* a power of two */
    int64_t waiting;    /* entries in all buckets */
} Front;

typedef struct {
    int64_t bucket;
    int32_t cell;
} Seed;

/* Between these no crossing's square is beyond what a double holds. */
static const double LEAST_CELL_M = 1e-100, MOST_CELL_M = 1e100;

/* How far to march: `limit`, and no more than `beyond` later than at a cell, if that is inside. */
typedef struct {
    double limit, beyond;
    Py_ssize_t row, col;
} Ending;

static int push(Front *front, int64_t bucket, int32_t cell)
{
    Bucket *into = &front->ring[bucket & (front->ring_size - 1)];
    if (into->count == into->room) {
        size_t room = into->room ? 2 * into->room : 256;
        int32_t *cells = realloc(into->cells, room * sizeof *cells);
        if (!cells)
            return -1;
        into->cells = cells;
        into->room = room;
    }
    into->cells[into->count++] = cell;
    front->waiting++;
    return 0;
}

/* The arrival that a cell's neighbours give it. */
static inline double upwind(const Front *front, Py_ssize_t cell, double crossing)
{
    const double *t = front->arrival + cell;
    double a = lesser(t[-1], t[1]), b = lesser(t[-front->width], t[front->width]);
    double gap = a - b;
    if (fabs(gap) >= crossing || isnan(gap))
        return lesser(a, b) + crossing;
    return 0.5 * (a + b + sqrt(2.0 * crossing * crossing - gap * gap));
}

static int pass_on(Front *front, Py_ssize_t from)
{
    const Py_ssize_t beside[4] = {-front->width, -1, 1, front->width};
    const double here = front->arrival[from];
    for (int n = 0; n < 4; n++) {
        const Py_ssize_t cell = from + beside[n];
        const double crossing = front->crossing[cell];
        if (crossing == 0.0 || front->arrival[cell] <= here)
            continue;
        const double time = upwind(front, cell, crossing);
        if (time >= front->arrival[cell] || time > front->limit)
            continue;
        front->arrival[cell] = time;
        if (push(front, (int64_t)(time * front->per_bucket), (int32_t)cell) < 0)
            return -1;
    }
    return 0;
}

/* The limit, once the cell that it goes by is settled: it lies before the bucket `now`. */
static void limit_by(Front *front, int64_t now)
{
    if (!front->until || !(front->arrival[front->until] * front->per_bucket < (double)now))
        return; /* inf never is */
    front->limit = lesser(front->limit, front->arrival[front->until] + front->beyond);
    front->until = 0;
}

/* Marches from the seeds, which are in order. */
static int run(Front *front, const Seed *seeds, size_t count)
{
    size_t next = 0;
    int64_t now = count ? seeds[0].bucket : 0;
    limit_by(front, now);
    while (front->waiting || next < count) {
        if (!front->waiting && seeds[next].bucket > now)
            now = seeds[next].bucket;
        for (; next < count && seeds[next].bucket == now; next++)
            if (push(front, now, seeds[next].cell) < 0)
                return -1;
        Bucket *bucket = &front->ring[now & (front->ring_size - 1)];
        for (size_t n = 0; n < bucket->count; n++) { /* it may grow meanwhile */
            const int32_t cell = bucket->cells[n];
            const double here = front->arrival[cell];
            if (here > front->limit || (int64_t)(here * front->per_bucket) != now)
                continue; /* too late, or it was passed on when it was earlier than this */
            if (pass_on(front, cell) < 0)
                return -1;
        }
        front->waiting -= (int64_t)bucket->count;
        bucket->count = 0;
        now++;
        limit_by(front, now);
    }
    limit_by(front, INT64_MAX);
    return 0;
}

static int by_bucket(const void *a, const void *b)
{
    const Seed *one = a, *other = b;
    if (one->bucket != other->bucket)
        return one->bucket < other->bucket ? -1 : 1;
    return (one->cell > other->cell) - (one->cell < other->cell);
}

/* The cells that are known and have a neighbour that is not, in order of arrival. */
static Seed *find_seeds(const Front *front, Py_ssize_t rows, Py_ssize_t cols, size_t *count)
{
    size_t room = 64;
    int64_t last = 0;
    int ordered = 1;
    Seed *seeds = malloc(room * sizeof *seeds);
    *count = 0;
    for (Py_ssize_t row = 1; row <= rows && seeds; row++) {
        for (Py_ssize_t cell = row * front->width + 1; cell <= row * front->width + cols; cell++) {
            const double *t = front->arrival + cell, *c = front->crossing + cell;
            const Py_ssize_t w = front->width;
            if (isinf(*t) || !((isinf(t[-1]) && c[-1] > 0) || (isinf(t[1]) && c[1] > 0) ||
                               (isinf(t[-w]) && c[-w] > 0) || (isinf(t[w]) && c[w] > 0)))
                continue;
            if (*count == room) {
                Seed *more = realloc(seeds, (room *= 2) * sizeof *seeds);
                if (!more) {
                    free(seeds);
                    return NULL;
                }
                seeds = more;
            }
            const int64_t bucket = (int64_t)(*t * front->per_bucket);
            ordered &= !*count || last <= bucket;
            seeds[(*count)++] = (Seed){last = bucket, (int32_t)cell};
        }
    }
    if (seeds && !ordered)
        qsort(seeds, *count, sizeof *seeds, by_bucket);
    return seeds;
}

/* Up to which number of a bucket the next one's is exact in double precision. */
static const double MOST_BUCKETS = 0x1p50;

static int can_arrive(double time, double per_bucket)
{
    return time >= 0.0 && (isinf(time) || time * per_bucket < MOST_BUCKETS);
}

/* Fills the padded arrays; the slowest crossing, or -1 for a speed or arrival that cannot be. */
static double fill(Front *front, const Grid *arrival, const Grid *speed, double cell_m)
{
    double slowest = 0.0;
    const int by_byte = speed->view.itemsize == 1;
    const Py_ssize_t padded = front->width * (arrival->rows + 2);
    for (Py_ssize_t n = 0; n < padded; n++)
        front->arrival[n] = INFINITY;
    for (Py_ssize_t row = 0; row < arrival->rows; row++) {
        double *t = front->arrival + (row + 1) * front->width + 1;
        double *c = front->crossing + (row + 1) * front->width + 1;
        const double *known = GRID_ROW(*arrival, double, row);
        for (Py_ssize_t col = 0; col < arrival->cols; col++) {
            if (!can_arrive(known[col], front->per_bucket))
                return -1.0;
            t[col] = known[col];
        }
        if (by_byte) {
            const uint8_t *open = GRID_ROW(*speed, uint8_t, row);
            for (Py_ssize_t col = 0; col < arrival->cols; col++)
                c[col] = open[col] ? cell_m : 0.0;
            slowest = cell_m;
        } else {
            const float *fast = GRID_ROW(*speed, float, row);
            for (Py_ssize_t col = 0; col < arrival->cols; col++) {
                if (!(fast[col] >= 0.0f && fast[col] <= 1.0f))
                    return -1.0;
                c[col] = fast[col] > 0.0f ? cell_m / fast[col] : 0.0;
                slowest = c[col] > slowest ? c[col] : slowest;
            }
        }
    }
    return slowest;
}

/* What the front came to by the limit; what was known stays. */
static void take(const Front *front, Grid *arrival)
{
    for (Py_ssize_t row = 0; row < arrival->rows; row++) {
        double *into = GRID_ROW(*arrival, double, row);
        const double *t = front->arrival + (row + 1) * front->width + 1;
        for (Py_ssize_t col = 0; col < arrival->cols; col++)
            if (t[col] <= front->limit)
                into[col] = t[col];
    }
}

/* How many buckets hold all that waits at a time, a power of two; 0 where those are too many. */
static int64_t ring_for(double slowest, double per_bucket)
{
    const double most = slowest * per_bucket + 2.0;
    int64_t size = 8;
    if (!(most <= 1 << 20))
        return 0;
    while ((double)size < most)
        size *= 2;
    return size;
}

/* Lays the ring out and marches, once the arrays are filled. */
static const char *march_filled(Front *front, Grid *arrival, double slowest)
{
    size_t count = 0;
    if (slowest < 0.0)
        return "an arrival below 0, not a number or too late, or a speed outside 0 to 1";
    front->ring_size = ring_for(slowest, front->per_bucket);
    if (!front->ring_size)
        return "a speed so small that it is none";
    front->ring = calloc((size_t)front->ring_size, sizeof *front->ring);
    Seed *seeds = find_seeds(front, arrival->rows, arrival->cols, &count);
    const int done = front->ring && seeds ? run(front, seeds, count) : -1;
    for (int64_t n = 0; front->ring && n < front->ring_size; n++)
        free(front->ring[n].cells);
    free(front->ring);
    free(seeds);
    if (done < 0)
        return NO_MEMORY;
    take(front, arrival);
    return NULL;
}

static const char *march(Grid *arrival, const Grid *speed, double cell_m, Ending *ending)
{
    const char *problem = NO_MEMORY;
    Front front = {.width = arrival->cols + 2,
                   .limit = ending->limit,
                   .beyond = ending->beyond,
                   .per_bucket = 2.0 / cell_m};
    if (!are_few(arrival->rows + 2, front.width))
        return TOO_MANY_CELLS;
    const size_t cells = (size_t)front.width * (size_t)(arrival->rows + 2);
    if (ending->row >= 0 && ending->row < arrival->rows && ending->col >= 0 &&
        ending->col < arrival->cols)
        front.until = (ending->row + 1) * front.width + ending->col + 1;
    front.arrival = malloc(cells * sizeof *front.arrival);
    front.crossing = calloc(cells, sizeof *front.crossing);
    if (front.arrival && front.crossing)
        problem = march_filled(&front, arrival, fill(&front, arrival, speed, cell_m));
    free(front.crossing);
    free(front.arrival);
    ending->limit = front.limit;
    return problem;
}

PyObject *kernel_march(PyObject *Py_UNUSED(module), PyObject *const *args, Py_ssize_t count)
{
    static const GridSpec specs[] = {{'d', 1, "arrival"}, {BYTES_OR_FLOATS, 0, "speed"}};
    Grid grids[2];
    double numbers[2], beyond;
    Py_ssize_t until[2];
    if (count_is("march", count, 7) < 0 || numbers_of(numbers, args + 2, 2) < 0 ||
        wholes_of(until, args + 4, 2) < 0 || numbers_of(&beyond, args + 6, 1) < 0)
        return NULL;
    const double cell_m = numbers[0];
    Ending ending = {numbers[1], beyond, until[0], until[1]};
    if (!(cell_m >= LEAST_CELL_M && cell_m <= MOST_CELL_M))
        return failed("march", "cell_m: cells of no size, or of one without end");
    if (isnan(ending.limit) || !(ending.beyond >= 0.0))
        return failed("march", "limit, beyond: no limit");
    if (grids_open(grids, args, specs, 2) < 0)
        return NULL;
    const int alike = grids_alike(grids, specs, 2);
    const char *problem = NULL;
    if (alike == 0) {
        Py_BEGIN_ALLOW_THREADS
        problem = march(&grids[0], &grids[1], cell_m, &ending);
        Py_END_ALLOW_THREADS
    }
    grids_close(grids, 2);
    if (problem)
        return failed("march", problem);
    return alike < 0 ? NULL : PyFloat_FromDouble(ending.limit);
}
