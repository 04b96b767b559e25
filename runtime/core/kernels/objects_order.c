/* Values by their rank. */
#include "objects.h"
#include <math.h>

enum { BUCKETS = 256, FEW = 128, MOST_RANKS = 4 };

static inline void swap(double *a, double *b)
{
    const double held = *a;
    *a = *b;
    *b = held;
}

/* Moves the k-th smallest to its place (Hoare's quickselect, the pivot the median of three). */
static double selected(double *values, size_t n, size_t k)
{
    double *first = values, *last = values + n - 1, *wanted = values + k;
    while (first < last) {
        double *middle = first + (last - first) / 2;
        if (*middle < *first)
            swap(middle, first);
        if (*last < *first)
            swap(last, first);
        if (*last < *middle)
            swap(last, middle);
        const double pivot = *middle;
        double *low = first, *high = last;
        while (low <= high) {
            while (*low < pivot)
                low++;
            while (pivot < *high)
                high--;
            if (low <= high)
                swap(low++, high--);
        }
        if (wanted <= high)
            last = high;
        else if (wanted >= low)
            first = low;
        else
            break;
    }
    return *wanted;
}

typedef struct {
    double low, high;
} Range;

static inline double lesser(double a, double b) { return a < b ? a : b; }

static inline double greater(double a, double b) { return a > b ? a : b; }

/* By two at a time, for none to wait for the one before it. */
static Range range_of(const double *values, size_t n)
{
    const size_t half = n / 2;
    const double *others = values + half;
    Range one = {values[0], values[0]}, other = {values[n - 1], values[n - 1]};
    for (size_t i = 0; i < half; i++) {
        one.low = lesser(values[i], one.low);
        one.high = greater(values[i], one.high);
        other.low = lesser(others[i], other.low);
        other.high = greater(others[i], other.high);
    }
    return (Range){lesser(one.low, other.low), greater(one.high, other.high)};
}

static inline uint32_t bucket_of(double value, double low, double scale)
{
    const uint32_t bucket = (uint32_t)(int32_t)((value - low) * scale);
    return bucket < BUCKETS ? bucket : BUCKETS - 1;
}

/* Only what shares a bucket with a value that is asked for is put in order: buckets are counted,
 * then those few are gathered, side by side, and all else is written where it is overwritten. */
static void by_bucket(const double *values, size_t n, const size_t *ranks, size_t count,
                      double *found, double *scratch, double low, double scale)
{
    uint32_t held[2][BUCKETS] = {{0}}, to[BUCKETS], step[BUCKETS] = {0}, first[BUCKETS];
    size_t before = 0, bucket = 0, gathered = 0, of[MOST_RANKS];
    for (size_t i = 0; i < n; i++) /* neighbours are much alike: two counts wait less */
        held[i & 1][bucket_of(values[i], low, scale)]++;
    for (size_t r = 0; r < count; r++) {
        while (before + held[0][bucket] + held[1][bucket] <= ranks[r]) {
            before += held[0][bucket] + held[1][bucket];
            bucket++;
        }
        of[r] = bucket;
        found[r] = (double)(ranks[r] - before);
        if (!step[bucket]) {
            step[bucket] = 1;
            first[bucket] = (uint32_t)gathered;
            gathered += held[0][bucket] + held[1][bucket];
        }
    }
    for (size_t k = 0; k < BUCKETS; k++)
        to[k] = step[k] ? first[k] : (uint32_t)gathered;
    for (size_t i = 0; i < n; i++) {
        const uint32_t own = bucket_of(values[i], low, scale);
        scratch[to[own]] = values[i];
        to[own] += step[own];
    }
    for (size_t r = 0; r < count; r++) {
        const size_t own = of[r];
        found[r] = selected(scratch + first[own], to[own] - first[own], (size_t)found[r]);
    }
}

void at_ranks(const double *values, size_t n, const size_t *ranks, size_t count, double *found,
              double *scratch)
{
    if (n > FEW) {
        const Range range = range_of(values, n);
        const double scale = (BUCKETS - 1) / (range.high - range.low);
        if (scale > 0.0 && isfinite(scale)) {
            by_bucket(values, n, ranks, count, found, scratch, range.low, scale);
            return;
        }
    }
    for (size_t i = 0; i < n; i++)
        scratch[i] = values[i];
    for (size_t r = 0; r < count; r++)
        found[r] = selected(scratch, n, ranks[r]);
}

double median(const double *values, size_t n, double *scratch)
{
    const size_t ranks[2] = {(n - 1) / 2, n / 2};
    double found[2];
    at_ranks(values, n, ranks, 2, found, scratch);
    return (found[0] + found[1]) / 2.0;
}
