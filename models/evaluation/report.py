"""The figures as Markdown, also what the model card holds."""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

WANTED = {
    "AP50, HM3D goals": ("≥ 0.75", ""),
    "AP50, RoboTHOR goals": ("≥ 0.68", ""),
    "AP50, household": ("", "≥ 0.45 on COCO, ≥ 0.25 on NYU or by ours alone"),
    "AP50, trained": ("≥ 0.50", ""),
    "AP50, held out": ("≥ 0.15", ""),
    "share of own AP": ("≥ 0.90", "≥ 0.90"),
    "room type": ("≥ 0.78", "≥ 0.70"),
    "calibration error": ("≤ 0.05", "≤ 0.05"),
    "reported": ("", "≥ 0.60; ≤ 10"),
    "false sightings": ("≤ 4.5", ""),
    "ms of one, 1 thread": ("≤ 60", "≤ 60"),
    "ms of one, 2 threads": ("≤ 35", "≤ 35"),
    "ms of several, 2 threads": ("≤ 60", "≤ 60"),
    "file, MB": ("≤ 12", "≤ 12"),
    "memory, MB": ("≤ 150", "≤ 150"),
}
"""Of renderings, and of photographs; "": nothing. models/weights/README.md has the same."""
ENOUGH = 0.9
"""Of the own AP, for a name to be understood."""
HEARD = ("understood as", "AP50", "ratio")

Row = tuple[str, str, str]  # what, measured, a key of WANTED


def markdown(report: dict[str, Any]) -> str:
    """The whole report."""
    parts = [_summary(report), _goals(report), _curve(report)]
    if report["by_size"]["sizes"]:
        parts.append(_sizes(report))
    parts.append(_classes(report))
    if report["second_look"]:
        parts.append(_twice(report["second_look"]))
    if report["synonyms"]:
        parts += [_synonyms(report["synonyms"]), _asked(report["asked"])]
    return "\n\n".join(parts)


def _summary(report: dict[str, Any]) -> str:
    parts = (_precision_rows, _name_rows, _score_rows, _cost_rows)
    domain = report["domain"]["is"] if "domain" in report else ""
    rows = [
        (what, measured, wanted(key, domain))
        for part in parts
        for what, measured, key in part(report)
    ]
    of = ", ".join(report.get("detectors", ())) or "a detector"
    if "domain" in report:
        of += f", taken for {report['domain']['is']} ({report['domain']['log_odds']:+.1f})"
    where = "other frames" if report["fitted_on_other_frames"] else "these same frames"
    fit = report["calibration"]
    note = (
        f"{of}: {report['frames']} frames. Threshold {report['threshold']:.2f} and calibration "
        f"(gain {fit['gain']:.3f}, shift {fit['shift']:.3f}) fitted on {where}."
    )
    return f"{_table(('', 'measured', 'wanted'), rows)}\n\n{note}"


def wanted(key: str, domain: str = "") -> str:
    """What a figure is to reach in images of a domain, or of either where that is not known."""
    renderings, photographs = WANTED.get(key, ("", ""))
    if domain or renderings == photographs:
        return (photographs if domain == "photographs" else renderings) or "–"
    said = {"renderings": renderings, "photographs": photographs}
    return ", ".join(f"{name} {value}" for name, value in said.items() if value)


def _precision_rows(report: dict[str, Any]) -> Iterator[Row]:
    for name, group in report["groups"].items():
        count = f"{group['categories']} of {group['of']} categories"
        low, high = group["interval"]
        measured = f"{_f(group['ap50'])} [{_f(low)}, {_f(high)}]"
        yield f"AP50, {name} ({count})", measured, f"AP50, {name}"
    twice = report["second_look"]
    if twice:
        count = f"{len(twice['categories'])} of {twice['of']} categories"
        said = f"AP50, held out, looked at twice ({count})"
        yield said, _f(twice["ap50"]), "AP50, held out"


def _name_rows(report: dict[str, Any]) -> Iterator[Row]:
    if not report["synonyms"]:
        return
    for prefix, how in (("", "the bare word"), ("understood_", "as the runtime understands it")):
        for key, said in (("mean", "synonyms"), ("mean_of_goals", "synonyms of goals")):
            share = _f(report["synonyms"][prefix + key])
            yield f"{said}: share of own AP, {how}", share, "share of own AP"
    other = report["asked"]
    said = f"other names ({len(other['rows'])}): share of own AP, as the runtime understands it"
    yield said, _f(other["understood_mean"]), "share of own AP"


def _score_rows(report: dict[str, Any]) -> Iterator[Row]:
    for key, said in (("room_top1", ""), ("room_top1_of_things", ", of views that show a thing")):
        yield f"room type, top-1{said}", _f(report[key]), "room type"
    for how, error in report["calibration_error"].items():
        yield f"calibration error, {how}", _f(error), "calibration error"
    for said in report["reported"]:
        where = f"where they show ({said['views']} views); false in 1,000 frames"
        what = f"HM3D goals, reported from {said['score']} on {where}"
        yield what, f"{_f(said['share'])}; {said['false_seen']:.1f}", "reported"
    goals = list(report["goals"].values())
    for key, said in (("false_seen", ""), ("false_seen_apart", ", none like it in view")):
        mean = sum(g[key] for g in goals) / max(len(goals), 1)
        what = f"false sightings in 1,000 frames without the goal{said}"
        yield what, f"{mean:.1f}", "false sightings"


def _cost_rows(report: dict[str, Any]) -> Iterator[Row]:
    if "cost" not in report:
        return
    of = "several" if len(report.get("detectors", ())) > 1 else "one"
    for threads, said in ((1, "1 thread"), (2, "2 threads")):
        cost = report["cost"][f"threads_{threads}"]
        took = f"{cost['ms']:.1f} (mean {cost['mean_ms']:.1f}, least {cost['least_ms']:.1f}, "
        took += f"ratio {cost['ratio']:.2f}, "
        took += f"CPU {cost['cpu_ms']:.1f})"
        yield f"ms a 640x480 frame, {threads} thread(s)", took, f"ms of {of}, {said}"
        if "twice_ms" in cost:
            what = f"ms a frame looked at twice, {threads} thread(s)"
            yield what, f"{cost['twice_ms']:.1f} ({cost['twice_memory_mb']:.0f} MB more)", ""
    yield "file, MB", f"{report['cost']['bytes'] / 1e6:.1f}", "file, MB"
    yield "memory, MB", f"{report['cost']['threads_1']['memory_mb']:.0f}", "memory, MB"


def _goals(report: dict[str, Any]) -> str:
    head = ("goal", "objects", "AP50", "precision", "recall", "false/1,000", "…none like it")
    rows = [
        (
            name, str(g["objects"]), _f(g["ap50"]), _f(g["precision"]), _f(g["recall"]),
            f"{g['false_seen']:.1f}", f"{g['false_seen_apart']:.1f}",
        )
        for name, g in report["goals"].items()
    ]  # fmt: skip
    return _table(head, rows)


def _curve(report: dict[str, Any]) -> str:
    rows = [
        (f"{r['threshold']:.1f}", f"{r['false_seen']:.1f}", _f(r["recall"]))
        for r in report["curve"]
    ]
    return _table(("threshold", "false/1,000, mean of goals", "recall, mean of goals"), rows)


def _sizes(report: dict[str, Any]) -> str:
    """Of what is searched for."""
    found, rows = report["by_size"], []
    for row in found["sizes"]:
        size, shares = f"{row['from_px']} to {row['to_px']}", (row["recall"], row["curve"])
        rows.append((size, str(row["objects"]), *map(_f, shares)))
    head = ("size, px of an image 640 wide", "objects", "recall", "by the curve")
    curve = found["curve"]
    note = (
        f"Goals, at a score of {found['score']:.2f}; the curve: top {curve['top']:.2f}, half of it "
        f"at {curve['half_px']:.1f} px, gain {curve['gain']:.1f} a doubling."
    )
    return f"{_table(head, rows)}\n\n{note}"


def _classes(report: dict[str, Any]) -> str:
    held, rows = report["held_out"], []
    for name, row in sorted(report["classes"].items(), key=lambda item: -item[1]["ap50"]):
        mark = " (held out)" if name in held else ""
        rows.append((name + mark, str(row["objects"]), _f(row["ap50"])))
    return _table(("category", "objects", "AP50"), rows)


def _twice(twice: dict[str, Any]) -> str:
    """What was held out of training, each as a goal of its own."""
    rows = [
        (name, r["as"], str(r["objects"]), _f(r["ap50"]), _f(r["recall"]), f"{r['false_seen']:.1f}")
        for name, r in sorted(twice["categories"].items(), key=lambda item: -item[1]["ap50"])
    ]
    head = ("held out, looked at twice", "as", "objects", "AP50", "recall", "false/1,000")
    table = _table(head, rows)
    error, false = _f(twice["calibration_error"]), f"{twice['false_seen']:.1f}"
    return f"{table}\n\nCalibration error {error}; {false} false sightings in the mean."


def _synonyms(synonyms: dict[str, Any]) -> str:
    rows = [
        (r["synonym"], r["category"], _f(r["own"]), _f(r["ap50"]), f"{r['ratio']:.2f}", *_heard(r))
        for r in synonyms["rows"]
    ]
    head = ("synonym", "category", "own AP50", "bare AP50", "ratio", *HEARD)
    return _table(head, rows) + "\n\n" + _left_out(synonyms)


def _asked(asked: dict[str, Any]) -> str:
    """The names that are not understood well enough."""
    rows = [
        (r["synonym"], r["category"], _f(r["own"]), *_heard(r))
        for r in asked["rows"]
        if r["understood_ratio"] < ENOUGH
    ]
    said = f"Of {len(asked['rows'])} other names, those with a share below {ENOUGH}:"
    table = _table(("name", "category", "own AP50", *HEARD), rows)
    return f"{said}\n\n{table}\n\n{_left_out(asked)}"


def _heard(row: dict[str, Any]) -> tuple[str, str, str]:
    return row["as"], _f(row["understood_ap50"]), f"{row['understood_ratio']:.2f}"


def _left_out(names: dict[str, Any]) -> str:
    return f"{names['left_out']} more left out: too few objects or too little AP to compare."


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def _f(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.3f}"
