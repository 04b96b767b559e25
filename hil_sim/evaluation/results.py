"""Finished episodes on disk: nothing that was finished is ever lost."""

import fcntl
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hil_sim.driving.episode_result import End, EpisodeResult
from hil_sim.driving.link import HarnessError
from hil_sim.driving.methods import METHODS
from hil_sim.ground_truth.episodes import Episode
from runtime.former_keys import modern

RUN_FILE = "run.json"
RESULTS_FILE, SUITE_FILE, TIMES_FILE = "episodes.jsonl", "suite.json", "times.jsonl"
LOCK_FILE = ".lock"
FORMER_MODELS = {"06f013d8935ca412": "1f57d91d3cd921bb"}
"""What run.json of a4db551 calls the models that are bundled: a digest of the manifest with its
comments, one of which has changed since."""
FRAMES = ("rendered", "recalled")
"""Counts that stand among the wall times, since they depend on what ran together."""


@contextmanager
def sole(out: Path) -> Iterator[None]:
    """OUT, made if need be, for one writer at a time; HarnessError while it has another."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        file = (out / LOCK_FILE).open("w")
    except OSError as error:
        raise HarnessError(f"{out}: cannot be written ({error.strerror})") from error
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise HarnessError(
                f"{out}: in use by another `hil-sim eval`; wait for it or choose another --out"
            ) from None
        yield


def run_of(out: Path) -> dict[str, Any]:
    """The configuration that a folder was driven with, by the names of today; {} where no run.json
    is."""
    path = out / RUN_FILE
    if not path.is_file():
        return {}
    run: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    settings = [modern(setting) for setting in run.get("settings", [])]
    models = str(run.get("models"))
    return run | {"settings": settings, "models": FORMER_MODELS.get(models, models)}


class Results:
    """Finished episodes in OUT/episodes.jsonl, one line each, the last of an episode counts. Who
    writes (`mend`) has OUT to himself (`sole`), and takes away a line that was never finished."""

    def __init__(self, out: Path, mend: bool = False) -> None:
        self._path = out / RESULTS_FILE
        self.by_key: dict[tuple[str, str], EpisodeResult] = {}
        if self._path.is_file():
            for line in self._path.read_text(encoding="utf-8").splitlines(keepends=True):
                if line.endswith("\n"):  # a torn line was never finished
                    self._keep(EpisodeResult.from_json(json.loads(line)))
                elif mend:
                    self._cut(len(line.encode()))

    def add(self, result: EpisodeResult) -> None:
        """Keep a result, on disk before this returns."""
        self._keep(result)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(result.to_json()) + "\n")

    def finished(self, method: str, episode: Episode) -> bool:
        """An episode that ended in an error is tried again."""
        result = self.by_key.get((method, episode.id))
        return result is not None and not result.ended.failed

    def timed(self, episodes: int, seconds: float, workers: int) -> None:
        """Note how long a run took, in a file of wall times."""
        row = {"episodes": episodes, "seconds": round(seconds, 1), "workers": workers}
        with self._path.with_name(TIMES_FILE).open("a", encoding="utf-8") as file:
            file.write(json.dumps({**row, "cores": os.cpu_count()}) + "\n")

    def settle(self, episodes: Sequence[Episode]) -> None:
        """Bring the file into one order, by episode and method, each result once: it no longer
        tells which worker was first."""
        place = {episode.id: number for number, episode in enumerate(episodes)}
        rank = {name: number for number, name in enumerate(METHODS)}
        keys = sorted(
            self.by_key, key=lambda k: (place.get(k[1], len(place)), rank.get(k[0], len(rank)), k)
        )
        if not keys:
            return
        draft = self._path.with_suffix(".part")
        lines = (json.dumps(self.by_key[key].to_json()) + "\n" for key in keys)
        draft.write_text("".join(lines), encoding="utf-8")
        os.replace(draft, self._path)

    def of(self, method: str, episodes: Sequence[Episode]) -> list[EpisodeResult]:
        """A method's results, in the suite's order."""
        keys = ((method, episode.id) for episode in episodes)
        return [self.by_key[key] for key in keys if key in self.by_key]

    def _keep(self, result: EpisodeResult) -> None:
        self.by_key[result.method, result.episode] = result

    def _cut(self, torn: int) -> None:
        with self._path.open("rb+") as file:
            file.truncate(self._path.stat().st_size - torn)


def errors(results: Sequence[EpisodeResult]) -> int:
    """Episodes that ended in an error; they count as failures."""
    return sum(result.ended.failed for result in results)


def falls(results: Sequence[EpisodeResult]) -> int:
    """Episodes in which the robot left the floor."""
    return sum(result.ended.end is End.FELL for result in results)


def stages(results: Sequence[EpisodeResult]) -> str:
    """Mean wall seconds an episode by stage and how many frames were rendered, as one line."""
    if not results:
        return "no episodes"
    means = mean_wall(results)
    total = means.pop("total", 0.0)
    rendered, recalled = (means.pop(name, 0.0) for name in FRAMES)
    parts = ", ".join(f"{name.removeprefix('runtime.')} {s:.1f}" for name, s in means.items())
    frames = f"{rendered:.0f} frames rendered, {recalled:.0f} recalled"
    return f"{total:.1f} s an episode: {parts}; {frames}"


def mean_wall(results: Sequence[EpisodeResult]) -> dict[str, float]:
    """Mean of each wall figure over the episodes; one that an episode lacks is 0 there."""
    names = list(dict.fromkeys(name for result in results for name in result.wall))
    return {n: sum(r.wall.get(n, 0.0) for r in results) / len(results) for n in names}
