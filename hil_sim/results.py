"""Finished episodes on disk: nothing that was finished is ever lost."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from hil_sim.episode_run import EpisodeResult
from hil_sim.episodes import Episode

RESULTS_FILE = "episodes.jsonl"


class Results:
    """Finished episodes in OUT/episodes.jsonl, one line each, the last of an episode counts."""

    def __init__(self, out: Path) -> None:
        self._path = out / RESULTS_FILE
        self.by_key: dict[tuple[str, str], EpisodeResult] = {}
        if self._path.is_file():
            for line in self._path.read_text(encoding="utf-8").splitlines(keepends=True):
                if line.endswith("\n"):  # a torn line was never finished
                    self._keep(EpisodeResult.from_json(json.loads(line)))
                else:
                    self._cut(len(line.encode()))

    def add(self, result: EpisodeResult) -> None:
        """Keep a result, on disk before this returns."""
        self._keep(result)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(asdict(result)) + "\n")

    def finished(self, method: str, episode: Episode) -> bool:
        """An episode that ended in an error is tried again."""
        result = self.by_key.get((method, episode.id))
        return result is not None and not result.ended.startswith("error")

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
    return sum(result.ended.startswith("error") for result in results)


def stages(results: Sequence[EpisodeResult]) -> str:
    """Mean wall seconds an episode by stage, as one line."""
    if not results:
        return "no episodes"
    names = list(dict.fromkeys(name for result in results for name in result.wall))
    means = {n: sum(r.wall.get(n, 0.0) for r in results) / len(results) for n in names}
    total = means.pop("total", 0.0)
    parts = ", ".join(f"{name.removeprefix('runtime.')} {s:.1f}" for name, s in means.items())
    return f"{total:.1f} s an episode: {parts}"
