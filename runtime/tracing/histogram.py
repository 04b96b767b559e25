"""Durations, counted in buckets of fixed edges: a constant of memory, however long the drive."""

import math
from dataclasses import dataclass, field

LEAST_S = 1e-5
PER_OCTAVE = 8  # a percentile is told 9 % too high at most
OCTAVES = 24  # up to 168 s
FIRST_OCTAVE, LAST_OCTAVE = 5, 21  # of those that are told by octave: 0.3 ms to 10 s


@dataclass
class Histogram:
    """Of one stage. One thread adds to it; others may read it meanwhile."""

    counts: list[int] = field(default_factory=lambda: [0] * (OCTAVES * PER_OCTAVE + 1))
    n: int = 0
    total_s: float = 0.0
    max_s: float = 0.0
    over: int = 0  # how many were over the stage's deadline

    def add(self, seconds: float) -> None:
        """Count one."""
        i = math.ceil(PER_OCTAVE * math.log2(seconds / LEAST_S)) if seconds > LEAST_S else 0
        self.counts[min(i, OCTAVES * PER_OCTAVE)] += 1
        self.n += 1
        self.total_s += seconds
        self.max_s = max(self.max_s, seconds)

    def percentile(self, share: float) -> float:
        """The upper edge of the bucket in which that share of all is reached, s, never above the
        greatest; 0 when there is none."""
        wanted, so_far = share * self.n, 0
        for i, count in enumerate(self.counts):
            so_far += count
            if count and so_far >= wanted:
                return min(self.max_s, LEAST_S * math.exp2(i / PER_OCTAVE))
        return self.max_s

    def by_octave(self) -> list[tuple[float, int]]:
        """(upper edge, s; how many are up to it) of every octave, then (inf, all): of one moment,
        whoever adds meanwhile."""
        counts = tuple(self.counts)
        edges = range(0, len(counts), PER_OCTAVE)
        upto = [(LEAST_S * math.exp2(i // PER_OCTAVE), sum(counts[: i + 1])) for i in edges]
        return [*upto[FIRST_OCTAVE:LAST_OCTAVE], (math.inf, sum(counts))]

    def told(self) -> dict[str, float]:
        """As JSON, in milliseconds but for the total."""
        shares = {"p50_ms": 0.5, "p90_ms": 0.9, "p99_ms": 0.99, "p999_ms": 0.999}
        told = {name: round(self.percentile(q) * 1e3, 3) for name, q in shares.items()}
        told |= {"max_ms": round(self.max_s * 1e3, 3), "total_s": round(self.total_s, 3)}
        return {"n": self.n, **told, "over": self.over}
