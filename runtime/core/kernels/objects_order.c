/* Values by their rank. */
#include "objects.h"
#include <math.h>

enum { BUCKETS = 256 /* a power of two */, FEW = 128, MOST_RANKS = 4 };

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

/* Four at a time, for none to wait for the one before it. */
Range range_of(const double *values, size_t n)
{
    double low[4], high[4];
    size_t i = 0;
    for (int k = 0; k < 4; k++)
        low[k] = high[k] = values[0];
    for (; i + 4 <= n; i += 4) {
        for (int k = 0; k < 4; k++) {
            low[k] = lesser(values[i + k], low[k]);
            high[k] = greater(values[i + k], high[k]);
        }
    }
    for (; i < n; i++) {
        low[0] = lesser(values[i], low[0]);
        high[0] = greater(values[i], high[0]);
    }
    return (Range){lesser(lesser(low[0], low[1]), lesser(low[2], low[3])),
                   greater(greater(high[0], high[1]), greater(high[2], high[3]))};
}

/* The scale leaves the highest within the last bucket; the mask, any value within some. */
static inline uint32_t bucket_of(double value, double low, double scale)
{
    return (uint32_t)(int32_t)((value - low) * scale) & (BUCKETS - 1);
}

/* Counts by bucket. Neighbours are much alike: four counts in turn wait less for each other. */
static void count_buckets(const double *values, size_t n, double low, double scale, uint32_t *held)
{
    uint32_t counts[4][BUCKETS] = {{0}};
    for (size_t i = 0; i < n; i++)
        counts[i & 3][bucket_of(values[i], low, scale)]++;
    for (size_t k = 0; k < BUCKETS; k++)
        held[k] = (counts[0][k] + counts[1][k]) + (counts[2][k] + counts[3][k]);
}

/* Only what shares a bucket with a value that is asked for is put in order: buckets are counted,
 * then those few are gathered, side by side. */
static void rank_by_bucket(const double *values, size_t n, const size_t *ranks, size_t count,
                           double *found, double *scratch, double low, double scale)
{
    uint32_t held[BUCKETS], to[BUCKETS];
    uint8_t wanted[BUCKETS] = {0};
    size_t before[MOST_RANKS], of[MOST_RANKS], passed = 0, bucket = 0, gathered = 0;
    count_buckets(values, n, low, scale, held);
    for (size_t r = 0; r < count; r++) {
        while (passed + held[bucket] <= ranks[r])
            passed += held[bucket++];
        of[r] = bucket;
        before[r] = passed;
        if (!wanted[bucket]) {
            wanted[bucket] = 1;
            to[bucket] = (uint32_t)gathered;
            gathered += held[bucket];
        }
    }
    for (size_t i = 0; i < n; i++) {
        const uint32_t own = bucket_of(values[i], low, scale);
        if (wanted[own])
            scratch[to[own]++] = values[i];
    }
    for (size_t r = 0; r < count; r++) {
        const size_t own = of[r], all = held[own];
        found[r] = selected(scratch + to[own] - all, all, ranks[r] - before[r]);
    }
}

void ranked(const double *values, size_t n, Range range, const size_t *ranks, size_t count,
            double *found, double *scratch)
{
    const double scale = (BUCKETS - 1) / (range.high - range.low);
    if (n > FEW && scale > 0.0 && isfinite(scale)) {
        rank_by_bucket(values, n, ranks, count, found, scratch, range.low, scale);
        return;
    }
    for (size_t i = 0; i < n; i++)
        scratch[i] = values[i];
    for (size_t r = 0; r < count; r++)
        found[r] = selected(scratch, n, ranks[r]);
}

void at_ranks(const double *values, size_t n, const size_t *ranks, size_t count, double *found,
              double *scratch)
{
    const Range range = n > FEW ? range_of(values, n) : (Range){0.0, 0.0};
    ranked(values, n, range, ranks, count, found, scratch);
}

double median_in(const double *values, size_t n, Range range, double *scratch)
{
    const size_t ranks[2] = {(n - 1) / 2, n / 2};
    double found[2];
    ranked(values, n, range, ranks, 2, found, scratch);
    return (found[0] + found[1]) / 2.0;
}

double median(const double *values, size_t n, double *scratch)
{
    return median_in(values, n, n > FEW ? range_of(values, n) : (Range){0.0, 0.0}, scratch);
}
