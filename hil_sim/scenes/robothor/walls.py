"""Interior walls of RoboTHOR's layouts: the data file, and the program that makes it.

    python -m hil_sim.scenes.robothor.walls --episodes DIR [--out walls.json]

Walls of the train layouts are inferred from the official episodes (`inference.py`). Those of Val1
and Val2 were given (inferred by others, the same way) and are kept; what this program would infer
for them is compared with them. Val3 has no episodes: of its walls only the parts behind paintings
are known.
"""

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import click
import numpy as np

from hil_sim.scenes.robothor.evidence import Floats, Path2, gather, hung_plane
from hil_sim.scenes.robothor.inference import SAME_M, WallRun, at_edges, infer
from hil_sim.scenes.robothor.metadata import APARTMENTS, MetadataError, apartment, layout_of
from hil_sim.scenes.robothor.regions import Segment
from runtime.errors import RfNavError

FILE = Path(__file__).parent / "walls.json"
FORMAT = "rf-nav-walls/1"
GIVEN, INFERRED, HUNG = "given", "inferred", "paintings"
MATCH_M = 0.1
"""Walls of two sets are the same where they are parallel and this near."""
SAMPLE_M = 0.01


@dataclass(frozen=True)
class Layout:
    """Interior walls of a layout; `source`: given, inferred or paintings. How many official paths
    were checked: none crosses a wall, and none comes nearer than `clearance_m`."""

    walls: tuple[Segment, ...]
    source: str
    paths: int = 0
    clearance_m: float | None = None


@cache
def layouts(path: Path = FILE) -> dict[str, Layout]:
    """Interior walls by layout (Train1 ... Val3)."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        return {
            name: Layout(
                tuple(((a, b), (c, d)) for (a, b), (c, d) in row["walls"]),
                row["source"],
                row["paths"],
                row["clearance_m"],
            )
            for name, row in data["layouts"].items()
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise MetadataError(f"{path}: not a file of walls: {error!r}") from None


def save(table: dict[str, Layout], path: Path) -> None:
    """Write walls, one layout a line."""
    rows = [f"    {json.dumps(name)}: {json.dumps(vars(row))}" for name, row in table.items()]
    note = "Metres, scene frame. given: see README.md; inferred: made by walls.py"
    head = f'{{\n  "format": "{FORMAT}",\n  "note": "{note}",\n  "layouts": {{\n'
    path.write_text(head + ",\n".join(rows) + "\n  }\n}\n", encoding="utf-8")


def clearance(walls: Sequence[Segment], paths: Sequence[Path2]) -> float:
    """Metres between the walls and the nearest path; 0 where one crosses a wall."""
    if not walls or not paths:
        return float("inf")
    pieces = np.concatenate([np.hstack([path[:-1], path[1:]]) for path in paths])
    return min(float(_distances(wall, pieces).min()) for wall in walls)


def _distances(wall: Segment, pieces: Floats) -> Floats:
    """(N, 4) segments -> (N,) metres to a wall."""
    a, b = np.array(wall[0]), np.array(wall[1])
    p, q = pieces[:, :2], pieces[:, 2:]
    ends = [_to_segment(p, a, b), _to_segment(q, a, b), _from_point(a, p, q), _from_point(b, p, q)]
    sides = _side(a, b, p) * _side(a, b, q) < 0
    crossing = sides & (_side(p, q, a) * _side(p, q, b) < 0)
    return np.where(crossing, 0.0, np.min(ends, axis=0))


def _side(a: Floats, b: Floats, p: Floats) -> Floats:
    d, e = b - a, p - a
    found: Floats = d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0]
    return found


def _to_segment(points: Floats, a: Floats, b: Floats) -> Floats:
    t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    found: Floats = np.hypot(*(points - a - t[:, None] * (b - a)).T)
    return found


def _from_point(point: Floats, p: Floats, q: Floats) -> Floats:
    d = q - p
    length = np.maximum((d * d).sum(axis=1), 1e-12)
    t = np.clip(((point - p) * d).sum(axis=1) / length, 0.0, 1.0)
    found: Floats = np.hypot(*(point - p - t[:, None] * d).T)
    return found


def agreement(found: Sequence[Segment], given: Sequence[Segment]) -> tuple[float, float]:
    """Precision and recall of the found walls by length: the shares of either set's length that
    runs within 10 cm of a parallel wall of the other."""
    return _covered(found, given), _covered(given, found)


def _covered(walls: Sequence[Segment], by: Sequence[Segment]) -> float:
    hits = total = 0
    for wall in walls:
        a, b = np.array(wall[0]), np.array(wall[1])
        count = max(2, round(float(np.hypot(*(b - a))) / SAMPLE_M))
        points = a + (b - a) * np.linspace(0.0, 1.0, count)[:, None]
        near = np.zeros(count, bool)
        for other in by:
            if _axis(other) == _axis(wall):
                near |= _to_segment(points, np.array(other[0]), np.array(other[1])) < MATCH_M
        hits, total = hits + int(near.sum()), total + count
    return hits / total if total else 1.0


def _axis(wall: Segment) -> int:
    return 0 if abs(wall[1][0] - wall[0][0]) > abs(wall[1][1] - wall[0][1]) else 1


def _rounded(wall: Segment) -> Segment:
    (a, b), (c, d) = wall
    return (round(a, 3), round(b, 3)), (round(c, 3), round(d, 3))


def behind_paintings(layout: str) -> tuple[Segment, ...]:
    """The parts of a layout's walls that paintings of its scenes hang on; overlapping ones, and
    what is left to an outer wall, are joined."""
    scenes = [name for name in APARTMENTS if layout_of(name) == layout]
    planes = [hung_plane(thing) for name in scenes for thing in apartment(name)]
    found: list[WallRun] = []
    for plane in sorted((p for p in planes if p), key=lambda p: (p.axis, p.low)):
        run = WallRun(plane.axis, round(plane.at, 3), plane.low, plane.high, hung=True)
        for i, other in enumerate(found):
            beside = other.axis == run.axis and abs(other.at - run.at) < SAME_M
            if beside and run.low <= other.high:
                found[i] = replace(other, high=max(run.high, other.high))
                break
        else:
            found.append(run)
    return tuple(_rounded(at_edges(run).segment) for run in found)


def _files(folder: Path) -> dict[str, list[Path]]:
    """Episode files of RoboTHOR's scenes anywhere below a folder, by layout."""
    found: dict[str, list[Path]] = {}
    for path in sorted(folder.rglob("*.json.gz")):
        name = path.name.removesuffix(".json.gz")
        if name in APARTMENTS:
            found.setdefault(layout_of(name), []).append(path)
    if not found:
        raise MetadataError(f"{folder}: holds no FloorPlan_*.json.gz, the official episodes")
    return found


def build(folder: Path, known: dict[str, Layout]) -> dict[str, Layout]:
    """The known walls, with those of every layout that has episodes made anew (but for given ones),
    and a line of report for each of these on stdout."""
    names = dict.fromkeys(layout_of(name) for name in APARTMENTS)
    table = {name: Layout(behind_paintings(name), HUNG) for name in names}
    table |= {name: row for name, row in known.items() if row.source != HUNG}
    for name, files in sorted(_files(folder).items(), key=lambda item: list(table).index(item[0])):
        evidence = gather(name, files)
        found = tuple(_rounded(run.segment) for run in infer(evidence))
        text = ""
        if table[name].source == GIVEN:
            precision, recall = agreement(found, table[name].walls)
            gap = clearance(found, evidence.paths)
            text = (
                f"; inferred: precision {precision:.2f}, recall {recall:.2f}, clearance {gap:.2f} m"
            )
            found = table[name].walls
        source = GIVEN if text else INFERRED
        least = round(clearance(found, evidence.paths), 3)
        table[name] = Layout(found, source, len(evidence.paths), least)
        click.echo(
            f"{name}: {len(found)} walls {source}, {len(evidence.paths)} paths, "
            f"smallest clearance {least:.2f} m{text}"
        )
    return table


@click.command()
@click.option("--episodes", type=click.Path(path_type=Path), required=True, help="Their folder.")
@click.option("--out", type=click.Path(path_type=Path), default=None, help="Write the walls here.")
def main(episodes: Path, out: Path | None) -> None:
    """Infer the walls of RoboTHOR's layouts from the official episodes; report the smallest
    clearance between walls and paths.

    \b
    Example: python -m hil_sim.scenes.robothor.walls --episodes ../shared/robothor/episodes
    """
    table = build(episodes, layouts())
    if out is not None:
        save(table, out)


if __name__ == "__main__":
    try:
        main()
    except RfNavError as error:
        click.echo(f"walls: {error}", err=True)
        sys.exit(2)
