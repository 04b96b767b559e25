"""What `hil-sim hazards` prints, and the file that it keeps its trials in."""

import json
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from hil_sim.driving.hazard_trials import HazardTrial
from runtime.errors import ConfigError

HEADER = (
    "| runtime | what | camera | trials | in view, braking allows | of those touched | others | "
    "of those touched | driven on against it, at most | slow enough after: median, max | "
    "zero where due: of, median, max | on again: median, max |",
    "|---|---|---|---|---|---|---|---|---|---|---|---|",
)


@dataclass(frozen=True)
class Tried:
    """Trials of a runtime, "this" or a commit; `camera` is how it looks, for people."""

    runtime: str
    camera: str
    brake_mps2: float
    done: Sequence[HazardTrial]

    def rows(self) -> Iterable[str]:
        """A line for each kind."""
        for kind in dict.fromkeys(trial.kind for trial in self.done):
            yield self._row(kind, [trial for trial in self.done if trial.kind == kind])

    def hit(self) -> bool:
        """Whether something was touched that was in view and could be braked for."""
        return any(t.touched and t.avoidable(self.brake_mps2) for t in self.done)

    def _row(self, kind: str, of_it: Sequence[HazardTrial]) -> str:
        sure = [trial for trial in of_it if trial.avoidable(self.brake_mps2)]
        others = [trial for trial in of_it if not trial.avoidable(self.brake_mps2)]
        due = [trial.shown_zero_s for trial in of_it if trial.due]
        figures = [
            self.runtime, kind, self.camera, len(of_it), len(sure), _touched(sure), len(others),
            _touched(others), f"{max(trial.pushed_s for trial in of_it):.2f} s",
            _spread(trial.slow_s for trial in of_it), f"{len(due)}: {_spread(due)}",
            _spread(trial.resumed_s for trial in of_it),
        ]  # fmt: skip
        return f"| {' | '.join(map(str, figures))} |"


def table(tried: Iterable[Tried]) -> Iterable[str]:
    """The table's lines."""
    yield from HEADER
    for one in tried:
        yield from one.rows()


def line(trial: HazardTrial) -> str:
    """A trial, for who waits."""
    zero = f"zero after {trial.zero_s:.2f} s" if trial.zero_s is not None else "no zero"
    end = "not touched"
    if trial.touched:
        end = f"touched at {trial.touch_mps:.2f} m/s, driven on for {trial.pushed_s:.2f} s"
    return (
        f"{trial.kind} {trial.high_m:g} m high, {trial.ahead_m:.2f} m ahead at {trial.v_mps:.2f} "
        f"m/s, {trial.pixels} px: {zero}, {end}, {trial.gap_m:.2f} m apart"
    )


class TrialsFile:
    """Trials as JSON: what is there already is not driven again. ConfigError for a file of other
    trials. None: they are kept nowhere."""

    def __init__(self, path: Path | None, how: dict[str, Any]) -> None:
        self._path, self._how = path, json.loads(json.dumps(how))
        self._trials: list[dict[str, Any]] = []
        if path is not None and path.exists():
            told = json.loads(path.read_text(encoding="utf-8"))
            if told.get("how") != self._how:
                raise ConfigError(f"{path}: holds other trials; another file, or the same options")
            self._trials = told["trials"]

    def of(self, runtime: str) -> list[HazardTrial]:
        """Those of a runtime."""
        return [HazardTrial(**t["trial"]) for t in self._trials if t["runtime"] == runtime]

    def keep(self, runtime: str, trials: Sequence[HazardTrial]) -> None:
        """More of them."""
        self._trials += [{"runtime": runtime, "trial": asdict(trial)} for trial in trials]
        if self._path is not None:
            text = json.dumps({"how": self._how, "trials": self._trials}, indent=1)
            self._path.write_text(text + "\n", encoding="utf-8")


def _touched(trials: Sequence[HazardTrial]) -> int:
    return sum(trial.touched for trial in trials)


def _spread(times: Iterable[float | None]) -> str:
    known = [time for time in times if time is not None]
    return f"{statistics.median(known):.2f}, {max(known):.2f} s" if known else "-"
