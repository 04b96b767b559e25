"""What is compiled is what NumPy makes of the same, to the last bit."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.core.distances.planner import Field
from runtime.core.distances.terrain import Terrain, clearance_between
from runtime.core.geometry import GridFrame
from runtime.core.kernels import _compiled
from runtime.core.kernels.steps import Berth, steps_clear, whole_steps

BERTH, TURNS, STEP_M, TURN_RAD = Berth(0.2, 1e-6, 5), range(-5, 7), 0.25, math.radians(30.0)
RULES = {"reach_m": 0.9, "same_m": 0.03, "most_steps": 6}
PLACE, RIGHT = (0.0, 0.0, 0.05, 0, 0), (0.9, 0.03, 0.0, 6, -5, 6)
SEEDS = st.integers(0, 2**32 - 1)


def steps_at(yaw_rad: float, widest: int) -> np.ndarray:
    headings = yaw_rad + np.arange(-widest, widest + 1) * TURN_RAD
    return STEP_M * np.stack([np.cos(headings), np.sin(headings)], axis=-1)


def all_clear(terrain: Terrain, xy: np.ndarray, step: np.ndarray) -> np.ndarray:
    """(N, 2) m, (N, 2) m -> (N,), all points of all steps at once."""
    points = xy[:, None] + np.linspace(0.0, 1.0, BERTH.samples + 1)[:, None] * step[:, None]
    cells, shape = terrain.frame.cells(points), np.array(terrain.frame.shape)
    inside = ((cells >= 1) & (cells < shape - 1)).all(axis=(1, 2))
    clearance = np.full(points.shape[:2], -math.inf)
    clearance[inside] = clearance_between(terrain, points[inside])
    needed = np.minimum(BERTH.clearance_m, np.maximum.accumulate(clearance, axis=1))
    return inside & ~(clearance[:, 1:] < needed[:, 1:] - BERTH.slack_m).any(axis=1)


def layer_by_layer(terrain: Terrain, field: Field, start, yaw_rad: float, best_m: float):
    """Places as (x, y, heading, turns made, what leads there), one layer after the other."""
    layer, seen = [(start, 0, 0, ())], set()
    nearest = (field.at(*start), start)
    for _ in range(RULES["most_steps"]):
        found: dict[tuple[int, int], tuple] = {}
        for order, (xy, facing, turns, way) in enumerate(layer):
            for turned in TURNS:
                step = steps_at(yaw_rad + (facing + turned) * TURN_RAD, 0)[0]
                end = tuple((np.array(xy) + step).tolist())
                key = tuple(np.round(np.array(end) / RULES["same_m"]).astype(int).tolist())
                away = np.hypot(end[0] - start[0], end[1] - start[1])
                if key in seen or away > RULES["reach_m"] or math.isinf(field.at(*end)):
                    continue
                if all_clear(terrain, np.array([xy]), step[None])[0]:
                    place = (turns + abs(turned), order, turned, end, facing + turned, way)
                    found[key] = min(found.get(key, place), place)
        seen |= set(found)
        layer = [(p[3], p[4], p[0], (*p[5], p[2])) for p in sorted(found.values())]
        for end, _, _, way in layer:
            if field.at(*end) <= best_m:
                return list(way), end
        nearest = min([nearest, *((field.at(*place[0]), place[0]) for place in layer)],
                      key=lambda place: place[0])  # fmt: skip
    return [], nearest[1]


def drawn(seed: int) -> tuple[Terrain, Field, np.random.Generator]:
    """Clearances as of posts here and there, and arrivals, each over a frame of its own."""
    rng = np.random.default_rng(seed)
    first = rng.integers(-9, 9, 2).tolist()
    frame = GridFrame(-1.0 + rng.random(), rng.random(), 0.05, 40, 50, *first)
    posts = rng.uniform((0, 0), frame.shape, (rng.integers(1, 12), 2))
    apart = np.indices(frame.shape)[..., None] - posts.T[:, None, None]
    clearance = (0.05 * np.hypot(*apart).min(axis=2)).astype(np.float32)
    terrain = Terrain(frame, clearance, clearance > 0.2, clearance)
    other = GridFrame(frame.x0_m, frame.y0_m, 0.05, 36, 46, frame.first_row + 2, frame.first_col)
    arrival = 0.05 * np.hypot(*(np.indices(other.shape) - rng.uniform(0, 40, (2, 1, 1))))
    arrival[rng.random(other.shape) < 0.1] = np.inf
    return terrain, Field(other, arrival), rng


def somewhere(frame: GridFrame, rng: np.random.Generator) -> tuple[float, float]:
    row, col = rng.integers(1, np.array(frame.shape) - 1)
    x_m, y_m = frame.centres(np.array([row, col], np.int32)) + rng.uniform(-0.02, 0.02, 2)
    return float(x_m), float(y_m)


@settings(max_examples=80, deadline=None)
@given(SEEDS)
def test_a_step_is_clear_as_its_points_are(seed: int):
    terrain, _, rng = drawn(seed)
    xy = np.array([somewhere(terrain.frame, rng) for _ in range(60)])
    steps = steps_at(rng.uniform(-4, 4), 30)[:60]
    clear = steps_clear(terrain.clearance_m, terrain.frame.place, xy, steps, BERTH)
    assert np.array_equal(clear, all_clear(terrain, xy, steps))
    part = terrain.clearance_m[3:-4, 2:-1]
    frame = GridFrame(*PLACE[:3], *part.shape)
    inner = Terrain(frame, part, part > 0.2, part)
    assert np.array_equal(
        steps_clear(part, frame.place, xy, steps, BERTH), all_clear(inner, xy, steps)
    )


@settings(max_examples=60, deadline=None)
@given(SEEDS)
def test_a_way_is_the_one_that_layers_lead_to(seed: int):
    terrain, field, rng = drawn(seed)
    start, yaw_rad = somewhere(terrain.frame, rng), rng.uniform(-4, 4)
    here_m = field.at(*start)
    best_m = max(0.0, here_m - rng.uniform(0.2, 0.6)) if np.isfinite(here_m) else 0.5
    steps = steps_at(yaw_rad, RULES["most_steps"] * TURNS[-1])
    way = whole_steps(
        terrain.clearance_m, terrain.frame.place, field.arrival_m, field.frame.place, start, steps,
        BERTH, best_m=best_m, turns=TURNS, **RULES,
    )  # fmt: skip
    assert way == layer_by_layer(terrain, field, start, yaw_rad, best_m)


def refused(**changed: object) -> str:
    given = {
        "clearance_m": np.ones((9, 9), np.float32), "arrival": np.ones((9, 9)),
        "steps": steps_at(0.0, 36), "terrain": PLACE, "field": PLACE, "body": tuple(BERTH),
        "start": (0.2, 0.2), "rules": RIGHT,
    }  # fmt: skip
    _compiled.whole_steps(*given.values())
    with pytest.raises((TypeError, ValueError)) as caught:
        _compiled.whole_steps(*(given | changed).values())
    return str(caught.value)


def test_what_cannot_be_is_refused_and_named():
    assert "start" in refused(start=(1e300, 0.0))
    assert "start" in refused(start=(math.nan, 0.0))
    assert "start" in refused(start=(0.0,))
    assert "reach_m" in refused(rules=(1e9, *RIGHT[1:]))
    assert "same_m" in refused(rules=(0.9, 0.0, *RIGHT[2:]))
    assert "up to 100 turns" in refused(rules=(*RIGHT[:5], 1000))
    assert "up to 100 steps" in refused(rules=(*RIGHT[:3], math.nan, -5, 6))
    assert "F odd" in refused(steps=steps_at(0.0, 35))
    assert "F odd" in refused(steps=steps_at(0.0, 36)[1:])
    assert "cell_m" in refused(field=(0.0, 0.0, 0.0, 0, 0))
    assert "samples" in refused(body=(0.2, 0.0, 0))
    assert "arrival" in refused(arrival=np.ones((9, 9), np.float32))
    clear, xy = np.empty((1, 2), bool), np.zeros((2, 2))
    with pytest.raises(ValueError, match="not \\(1, N\\)"):
        _compiled.steps_clear(clear, np.ones((9, 9), np.float32), xy, xy[:1], PLACE, tuple(BERTH))
