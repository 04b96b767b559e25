"""The picture of an episode: what the robot knew of the home, and what it did there."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from numpy.typing import NDArray

from hil_sim.evaluation.label_places import LINE_PT, LabelPlaces
from runtime.journal import read_journal, read_map
from runtime.map_look import COLOURS, RGB, dots_from_middle, rgb, room_tint

CERTAIN = 0.6  # objects at least this sure are drawn
MARGIN_M = 0.6
DISC_M, LEAST_P = 1.5, 0.02  # radius of a disc that is sure; what is less likely is not drawn
TOLD_P = 3  # of so many discs, the likeliest, the number is written
SOFT, LIGHT = 0.16, 0.25  # how much of a disc and of a thing is filled
LIGHTER = 0.5  # so much is a thing lighter than what it stands on
ROOM_M2 = 1.0  # of a part of the floor that its room's name is written on
SPOTS = 40  # where that may stand, at most
JOURNAL_FILE = "decisions.jsonl"
WIDTH_IN, LEGEND_IN = 8.0, 2.2
STAR_PT = 18.0  # a target's name stands that much below its middle, where the star is, or above
BESIDE_PT = tuple(part * LINE_PT for part in (0.0, 1.2, -1.2, 2.0, -2.0))  # a thing's name

Extent = tuple[float, float, float, float]
Legend = dict[str, Any]  # what was drawn, by what it is called; in the order of LEGEND
LEGEND = (
    "start", "path and end", "decision", "target", "frontier (id)", "elected frontier", "thing",
    "sought thing", "obstacle", "unknown", "no floor", "expected (p)",
)  # fmt: skip


def draw_map(run_dir: Path, out: Path) -> Path:
    """run_dir/{map.npz, decisions.jsonl, summary.json} -> a top-down PNG at `out`."""
    arrays, meta = read_map(run_dir)
    summary = _summary(run_dir)
    window = _window(arrays, meta)
    wide_m, high_m = window[1] - window[0], window[3] - window[2]
    size_in = (WIDTH_IN + LEGEND_IN, WIDTH_IN * high_m / wide_m + 1.0)
    figure = Figure(figsize=size_in, dpi=110, layout="constrained")
    axes = figure.add_subplot()
    legend: Legend = {}
    rooms = _ground(axes, arrays, meta, legend)
    labels = LabelPlaces(window, wide_m / (WIDTH_IN * 72))
    labels.keep(arrays["path_xy"][-1], "end")
    if meta["stopped_at"] is not None:
        labels.keep(meta["stopped_at"], "star", STAR_PT / 2)
    journal = run_dir / JOURNAL_FILE
    lines = list(read_journal(journal)) if journal.is_file() else []
    decisions = [line for line in lines if line["kind"] == "decision"]
    _path(axes, arrays, [line["step"] for line in decisions], legend)
    _target(axes, meta, summary, legend)
    _objects(axes, meta, labels, legend, goal=True)
    _frontiers(axes, meta, labels, legend)
    _objects(axes, meta, labels, legend, goal=False)
    _belief(axes, decisions, labels, legend)
    _name_rooms(axes, rooms, meta, labels)
    axes.set_xlim(*window[:2])
    axes.set_ylim(*window[2:])
    axes.set_title(_title(meta, summary), fontsize=11, loc="left")
    axes.set_xlabel("x, m (forward at the start)")
    axes.set_ylabel("y, m")
    axes.set_aspect("equal")
    handles = [legend[name] for name in (*LEGEND, *rooms) if name in legend]
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=8)
    figure.savefig(out)
    return out


def _summary(run_dir: Path) -> dict[str, Any]:
    path = run_dir / "summary.json"
    table: dict[str, Any] = json.loads(path.read_text()) if path.is_file() else {}
    return table


def _extent(meta: dict[str, Any], shape: tuple[int, ...]) -> Extent:
    f = meta["frame"]
    r = f["resolution_m"]
    return f["x0_m"], f["x0_m"] + shape[1] * r, f["y0_m"], f["y0_m"] + shape[0] * r


def _ground(
    axes: Axes, arrays: dict[str, NDArray[Any]], meta: dict[str, Any], legend: Legend
) -> dict[str, NDArray[np.bool_]]:
    """Free, occupied and unknown cells, free ones tinted by type of room; the cells of each."""
    free, occupied = arrays["free"], arrays["occupied"]
    image = np.empty((*free.shape, 3), np.uint8)
    image[:] = rgb("unknown")
    legend["unknown"] = Patch(color=COLOURS["unknown"], label="unknown")
    image[free] = rgb("free")
    rooms: dict[str, NDArray[np.bool_]] = {}
    evidence = arrays["rooms"].astype(np.float32)
    if evidence.size:
        kind = evidence.argmax(axis=0)
        known = free & (evidence.sum(axis=0) > 1.0)
        for i, name in enumerate(meta["room_names"]):
            cells = known & (kind == i)
            if cells.any():
                rooms[name] = cells
                image[cells] = room_tint(name)
                legend[name] = Patch(color=_parts(room_tint(name)), label=name)
    drops = arrays.get("drops", np.zeros(free.shape, bool))  # none in a map of an earlier version
    for cells, colour, name in ((occupied, "wall", "obstacle"), (drops, "drop", "no floor")):
        if cells.any():
            image[cells] = rgb(colour)
            legend[name] = Patch(color=COLOURS[colour], label=name)
    axes.imshow(image, origin="lower", extent=_extent(meta, free.shape), interpolation="nearest")
    return rooms


def _name_rooms(
    axes: Axes, rooms: dict[str, NDArray[np.bool_]], meta: dict[str, Any], labels: LabelPlaces
) -> None:
    """The type's name deep inside each of its larger parts, where it covers no other word."""
    f = meta["frame"]
    r = f["resolution_m"]
    for name, cells in rooms.items():
        count, parts, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8))
        for i in range(1, count):
            if stats[i, cv2.CC_STAT_AREA] * r**2 < ROOM_M2:
                continue
            inside = cv2.distanceTransform(np.pad(parts == i, 1).astype(np.uint8), cv2.DIST_L2, 3)
            deepest = np.argsort(inside[1:-1, 1:-1], axis=None)[::-1]
            some = deepest[: stats[i, cv2.CC_STAT_AREA] // 2]
            rows, cols = np.divmod(some[:: max(1, len(some) // SPOTS)], cells.shape[1])
            middles = np.stack([f["x0_m"] + (cols + 0.5) * r, f["y0_m"] + (rows + 0.5) * r], 1)
            at = labels.first(middles, name, 9)
            if at:
                axes.text(*at, name, ha="center", va="center", fontsize=9, color="0.45",
                          style="italic", zorder=2.8)  # fmt: skip


def _frontiers(axes: Axes, meta: dict[str, Any], labels: LabelPlaces, legend: Legend) -> None:
    """Dots, and on one of its own each one's id; the elected first."""
    for one in sorted(meta["frontiers"], key=lambda one: one["id"] != meta["elected"]):
        if one["distance_m"] is None:
            continue  # no way leads there
        dots = dots_from_middle(one["cells_xy"])
        name = "elected frontier" if one["id"] == meta["elected"] else "frontier (id)"
        colour = COLOURS["taken" if one["id"] == meta["elected"] else "frontier"]
        axes.scatter(dots[:, 0], dots[:, 1], s=3, marker="s", color=colour, zorder=3)
        legend[name] = Line2D([], [], marker="s", color=colour, ls="", label=name)
        at = labels.first(dots, str(one["id"]))
        if at is None:
            labels.keep(at := tuple(dots[0]), str(one["id"]))
        frame = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.8}
        axes.text(*at, str(one["id"]), color=colour, fontsize=7, weight="bold", ha="center",
                  va="center", bbox=frame, zorder=6)  # fmt: skip


def _objects(
    axes: Axes, meta: dict[str, Any], labels: LabelPlaces, legend: Legend, *, goal: bool
) -> None:
    """Outlines and names of the objects, grey, of what is sought green; the surest first. What has
    no room for its name is left out."""
    drawn = [o for o in meta["objects"] if (o["name"] == meta["goal"]) == goal]
    name = "sought thing" if goal else "thing"
    colour = COLOURS["goal" if goal else "thing"]
    for thing in sorted(drawn, key=lambda o: -o["confidence"]):
        if thing["confidence"] < CERTAIN and not thing["rejections"]:
            continue
        text = thing["name"] + (" (rejected)" if thing["rejections"] else "")
        x, y = thing["xy"]
        lines = (-STAR_PT, STAR_PT) if goal else BESIDE_PT
        at = labels.first([(x, y + line * labels.point_m) for line in lines], text)
        if at is None:
            continue
        outline = cv2.convexHull(np.array(thing["cells_xy"], np.float32))[:, 0]
        axes.fill(*outline.T, fc=COLOURS["halo"], alpha=LIGHTER, lw=0, zorder=4 + goal / 2)
        fill = (*_parts(rgb("goal" if goal else "thing")), LIGHT)
        axes.fill(*outline.T, fc=fill, ec=colour, lw=1.0, zorder=4 + goal / 2)
        legend[name] = Patch(fc=fill, ec=colour, label=name)
        frame = {"boxstyle": "round,pad=0.2", "fc": "white", "ec": colour, "alpha": 0.9, "lw": 0.6}
        axes.annotate(text, at, fontsize=7, ha="center", va="center", zorder=7, bbox=frame)


def _parts(colour: RGB) -> tuple[float, float, float]:
    """As matplotlib has it."""
    return colour[0] / 255, colour[1] / 255, colour[2] / 255


def _belief(
    axes: Axes, decisions: list[dict[str, Any]], labels: LabelPlaces, legend: Legend
) -> None:
    """Where the goal was expected by the newest decision that tells it, as discs below all else
    whose area is the probability, which is written on the likeliest."""
    told: list[dict[str, Any]] = next(
        (d["belief"]["places"] for d in reversed(decisions) if d.get("belief")), []
    )
    places = sorted((p for p in told if p["p"] >= LEAST_P), key=lambda place: -place["p"])
    for number, place in enumerate(places):
        radius_m = DISC_M * place["p"] ** 0.5
        disc = Circle(place["xy"], radius_m, color=COLOURS["belief"], alpha=SOFT, lw=0)
        disc.set_zorder(2.5)
        axes.add_patch(disc)
        legend["expected (p)"] = Patch(color=COLOURS["belief"], alpha=SOFT, label="expected (p)")
        if number >= TOLD_P:
            continue
        text = f"{100 * place['p']:.0f} %"
        x, y = place["xy"]
        round_it = [(x, y + part * radius_m) for part in (0.0, 0.6, -0.6, 1.1, -1.1)]
        at = labels.first(round_it, text)
        if at:
            frame = {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.8}
            axes.annotate(text, at, fontsize=7, ha="center", va="center", color=COLOURS["belief"],
                          weight="bold", bbox=frame, zorder=6)  # fmt: skip


def _path(axes: Axes, arrays: dict[str, NDArray[Any]], decided: list[int], legend: Legend) -> None:
    """The way that was driven, and where on it, by step, decisions were made."""
    path, colour = arrays["path_xy"], COLOURS["path"]
    axes.plot(*path.T, color=colour, lw=1.8, zorder=5)
    axes.plot(*path[0], "o", color=COLOURS["goal"], ms=9, mec="white", zorder=8)
    axes.plot(*path[-1], "s", color=colour, ms=9, mec="white", zorder=8)
    legend["start"] = Line2D([], [], marker="o", color=COLOURS["goal"], ls="", label="start")
    legend["path and end"] = Line2D([], [], marker="s", color=colour, ls="-", label="path and end")
    at = path[[s for s in decided if s < len(path)]]
    if len(at):
        axes.plot(*at.T, ".", color="black", ms=5, zorder=6)
        legend["decision"] = Line2D([], [], marker=".", color="black", ls="", label="decision")


def _target(axes: Axes, meta: dict[str, Any], summary: dict[str, Any], legend: Legend) -> None:
    if meta["stopped_at"] is not None:
        colour = COLOURS["goal" if summary.get("success") else "zone"]
        axes.plot(*meta["stopped_at"], "*", color=colour, ms=20, mec="black", zorder=9)
        legend["target"] = Line2D([], [], marker="*", color=colour, mec="black", ls="", ms=12,
                                  label="target")  # fmt: skip


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
