"""The picture of an episode: what the robot knew of the home, and what it did there."""

import json
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from numpy.typing import NDArray

from runtime.journal import read_journal, read_map

UNKNOWN, FREE, OCCUPIED = (0.80, 0.81, 0.83), (1.0, 1.0, 1.0), (0.22, 0.24, 0.28)
DROP, EXPECTED = (0.72, 0.20, 0.16), (0.46, 0.20, 0.62)
ROOM_STRENGTH = 0.28
CERTAIN = 0.6  # objects at least this sure are named
MARGIN_M = 0.6
DISC_M, LEAST_P = 1.5, 0.02  # radius of a disc that is sure; what is less likely is not drawn
JOURNAL_FILE = "decisions.jsonl"
WIDTH_IN, LEGEND_IN = 8.0, 2.2
CHARACTER_PT, LINE_PT = 4.4, 11.0  # of a label, with its frame
STAR_PT = 18.0  # a target's name stands that much below its middle, where the star is

Extent = tuple[float, float, float, float]


def draw_map(run_dir: Path, out: Path) -> Path:
    """run_dir/{map.npz, decisions.jsonl, summary.json} -> a top-down PNG at `out`."""
    arrays, meta = read_map(run_dir)
    summary = _summary(run_dir)
    window = _window(arrays, meta)
    wide_m, high_m = window[1] - window[0], window[3] - window[2]
    size_in = (WIDTH_IN + LEGEND_IN, WIDTH_IN * high_m / wide_m + 1.0)
    figure = Figure(figsize=size_in, dpi=110, layout="constrained")
    axes = figure.add_subplot()
    rooms = _ground(axes, arrays, meta)
    _frontiers(axes, meta)
    _objects(axes, meta, wide_m / (WIDTH_IN * 72))
    journal = run_dir / JOURNAL_FILE
    lines = list(read_journal(journal)) if journal.is_file() else []
    decisions = [line for line in lines if line["kind"] == "decision"]
    believed = _belief(axes, decisions)
    _path(axes, arrays, [line["step"] for line in decisions])
    _target(axes, meta, summary)
    axes.set_xlim(*window[:2])
    axes.set_ylim(*window[2:])
    axes.set_title(_title(meta, summary), fontsize=11, loc="left")
    axes.set_xlabel("x, m (forward at the start)")
    axes.set_ylabel("y, m")
    axes.set_aspect("equal")
    handles = _legend(meta, rooms, bool(_drops(arrays).any()), believed)
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8)
    figure.savefig(out)
    return out


def _summary(run_dir: Path) -> dict[str, Any]:
    path = run_dir / "summary.json"
    table: dict[str, Any] = json.loads(path.read_text()) if path.is_file() else {}
    return table


def _colours(n: int, map_name: str) -> list[tuple[float, float, float]]:
    table = mpl.colormaps[map_name]
    return [table(i % table.N)[:3] for i in range(n)]


def _extent(meta: dict[str, Any], shape: tuple[int, ...]) -> Extent:
    f = meta["frame"]
    r = f["resolution_m"]
    return f["x0_m"], f["x0_m"] + shape[1] * r, f["y0_m"], f["y0_m"] + shape[0] * r


def _ground(axes: Axes, arrays: dict[str, NDArray[Any]], meta: dict[str, Any]) -> list[int]:
    """Free, occupied and unknown cells, free ones tinted by room type; returns the types seen."""
    free, occupied = arrays["free"], arrays["occupied"]
    image = np.empty((*free.shape, 3))
    image[:] = UNKNOWN
    image[free] = FREE
    seen: list[int] = []
    evidence = arrays["rooms"].astype(np.float32)
    if evidence.size:
        kind = evidence.argmax(axis=0)
        known = free & (evidence.sum(axis=0) > 1.0)
        for i, colour in enumerate(_colours(len(meta["room_names"]), "Set2")):
            cells = known & (kind == i)
            if cells.any():
                seen.append(i)
                image[cells] = (1 - ROOM_STRENGTH) * 1.0 + ROOM_STRENGTH * np.array(colour)
                _name_room(axes, cells, meta, meta["room_names"][i])
    image[occupied] = OCCUPIED
    image[_drops(arrays)] = DROP
    axes.imshow(image, origin="lower", extent=_extent(meta, free.shape), interpolation="nearest")
    return seen


def _drops(arrays: dict[str, NDArray[Any]]) -> NDArray[np.bool_]:
    """(R, C) where the floor drops; nowhere in a map of an earlier version."""
    return arrays.get("drops", np.zeros(arrays["free"].shape, bool))


def _name_room(axes: Axes, cells: NDArray[np.bool_], meta: dict[str, Any], name: str) -> None:
    """The room type's name in the middle of each of its larger patches."""
    import cv2

    f = meta["frame"]
    count, labels, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8))
    for i in range(1, count):
        if stats[i, cv2.CC_STAT_AREA] * f["resolution_m"] ** 2 < 1.0:
            continue
        rows, cols = np.nonzero(labels == i)
        x = f["x0_m"] + (np.median(cols) + 0.5) * f["resolution_m"]
        y = f["y0_m"] + (np.median(rows) + 0.5) * f["resolution_m"]
        axes.text(x, y, name, ha="center", fontsize=9, color="0.45", style="italic", zorder=2)


def _frontiers(axes: Axes, meta: dict[str, Any]) -> None:
    for frontier in meta["frontiers"]:
        if frontier["distance_m"] is None:
            continue  # no way leads there
        cells = np.array(frontier["cells_xy"])
        chosen = frontier["id"] == meta["elected"]
        colour = "tab:orange" if chosen else "tab:cyan"
        axes.scatter(cells[:, 0], cells[:, 1], s=3, marker="s", color=colour, zorder=3)
        x, y = cells.mean(axis=0)
        axes.text(x, y, str(frontier["id"]), color=colour, fontsize=7, weight="bold", zorder=6)


def _objects(axes: Axes, meta: dict[str, Any], point_m: float) -> None:
    """Cells and names of the objects; `point_m`: metres to a point of the page. Where names would
    cover each other the goal's stays, then the surest."""
    names = sorted({o["name"] for o in meta["objects"]})
    colour = dict(zip(names, _colours(len(names), "tab20"), strict=True))
    drawn = [o for o in meta["objects"] if o["confidence"] >= CERTAIN or o["rejections"]]
    taken: list[Extent] = []
    for thing in sorted(drawn, key=lambda o: (o["name"] != meta["goal"], -o["confidence"])):
        tint = colour[thing["name"]]
        x, y = np.array(thing["cells_xy"]).T
        axes.scatter(x, y, s=4, marker="s", color=tint, alpha=0.8, zorder=4)
        text = thing["name"] + (" (rejected)" if thing["rejections"] else "")
        at = (thing["xy"][0], thing["xy"][1] - STAR_PT * point_m * (thing["name"] == meta["goal"]))
        place = _place(at, text, point_m)
        if any(_meet(place, other) for other in taken):
            continue
        taken.append(place)
        frame = {"boxstyle": "round,pad=0.2", "fc": "white", "ec": tint, "alpha": 0.9}
        axes.annotate(text, at, fontsize=7, ha="center", va="center", zorder=7, bbox=frame)


def _place(xy: tuple[float, float], text: str, point_m: float) -> Extent:
    """Where a label of this text lies on the map, about."""
    half_x, half_y = len(text) * CHARACTER_PT * point_m / 2, LINE_PT * point_m / 2
    return xy[0] - half_x, xy[0] + half_x, xy[1] - half_y, xy[1] + half_y


def _meet(a: Extent, b: Extent) -> bool:
    return a[0] < b[1] and b[0] < a[1] and a[2] < b[3] and b[2] < a[3]


def _belief(axes: Axes, decisions: list[dict[str, Any]]) -> bool:
    """Where the goal was expected by the newest decision that tells it, as discs whose area is the
    probability; whether there was anything to draw."""
    told: list[dict[str, Any]] = next(
        (d["belief"]["places"] for d in reversed(decisions) if d.get("belief")), []
    )
    places = [place for place in told if place["p"] >= LEAST_P]
    for place in places:
        disc = Circle(place["xy"], DISC_M * place["p"] ** 0.5, color=EXPECTED, alpha=0.35, lw=0)
        disc.set_zorder(2.5)
        axes.add_patch(disc)
        text = f"{100 * place['p']:.0f} %"
        axes.annotate(text, place["xy"], fontsize=6, ha="center", va="center", color=EXPECTED)
    return bool(places)


def _path(axes: Axes, arrays: dict[str, NDArray[Any]], decided: list[int]) -> None:
    """The way that was driven, and where on it, by step, decisions were made."""
    path = arrays["path_xy"]
    axes.plot(*path.T, color="tab:blue", lw=1.8, zorder=5)
    axes.plot(*path[0], "o", color="tab:green", ms=9, mec="white", zorder=8)
    axes.plot(*path[-1], "s", color="tab:blue", ms=9, mec="white", zorder=8)
    at = path[[s for s in decided if s < len(path)]]
    axes.plot(*at.T, ".", color="navy", ms=5, zorder=6)


def _target(axes: Axes, meta: dict[str, Any], summary: dict[str, Any]) -> None:
    if meta["stopped_at"] is not None:
        colour = "tab:green" if summary.get("success") else "tab:red"
        axes.plot(*meta["stopped_at"], "*", color=colour, ms=20, mec="black", zorder=9)


def _window(arrays: dict[str, NDArray[Any]], meta: dict[str, Any]) -> Extent:
    """What is known, with a margin: x from, to, y from, to, m."""
    rows, cols = np.nonzero(arrays["free"] | arrays["occupied"])
    f = meta["frame"]
    x0, y0, r = f["x0_m"], f["y0_m"], f["resolution_m"]
    return (
        x0 + cols.min() * r - MARGIN_M, x0 + cols.max() * r + MARGIN_M,
        y0 + rows.min() * r - MARGIN_M, y0 + rows.max() * r + MARGIN_M,
    )  # fmt: skip


def _title(meta: dict[str, Any], summary: dict[str, Any]) -> str:
    title = f"find a {meta['goal']}"
    if not summary:
        return title
    result = "success" if summary.get("success") else "failure"
    where, how = summary.get("scene", "?"), summary.get("method")
    title = f"{title} in {where}" + (f" by {how}" if how else "")
    parts = [f"{title}: {result} ({summary.get('ended', '')})"]
    if summary.get("path_m") is not None:
        shortest, spl = summary.get("shortest_path_m"), summary.get("spl")
        parts.append(
            f"{summary.get('steps')} steps, {summary['path_m']:.1f} m driven"
            + (f", shortest {shortest:.1f} m" if shortest is not None else "")
            + (f", SPL {spl:.2f}" if spl is not None else "")
        )
    return "\n".join(parts)


def _legend(meta: dict[str, Any], rooms: list[int], drops: bool, believed: bool) -> list[Any]:
    colours = _colours(len(meta["room_names"]), "Set2")
    tint = [
        Patch(
            color=(
                1 - ROOM_STRENGTH * (1 - colours[i][0]),
                1 - ROOM_STRENGTH * (1 - colours[i][1]),
                1 - ROOM_STRENGTH * (1 - colours[i][2]),
            ),
            label=meta["room_names"][i],
        )
        for i in rooms
    ]
    return [
        Line2D([], [], marker="o", color="tab:green", ls="", label="start"),
        Line2D([], [], marker="s", color="tab:blue", ls="-", label="path and end"),
        Line2D([], [], marker=".", color="navy", ls="", label="decision"),
        Line2D([], [], marker="*", color="tab:green", mec="black", ls="", ms=12, label="target"),
        Line2D([], [], marker="s", color="tab:cyan", ls="", label="frontier (id)"),
        Line2D([], [], marker="s", color="tab:orange", ls="", label="elected frontier"),
        Patch(color=OCCUPIED, label="obstacle"),
        Patch(color=UNKNOWN, label="unknown"),
        *([Patch(color=DROP, label="no floor")] if drops else []),
        *([Patch(color=EXPECTED, alpha=0.35, label="expected (p)")] if believed else []),
        *tint,
    ]
