"""Drawing from counted rooms, and measuring where things rest."""

import itertools
import json
import random
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from hil_sim.commands.generate import generate_command
from hil_sim.scenes.format import ROOM_TYPES, SceneObject
from hil_sim.scenes.furniture import surface_stats
from hil_sim.scenes.furniture.boxes import Box, box_of
from hil_sim.scenes.furniture.surfaces import lies_on, resting_place
from hil_sim.scenes.generated.home import generate
from hil_sim.scenes.generated.placement import habits
from hil_sim.scenes.scene_file import load_scene


@pytest.mark.parametrize("kind", ROOM_TYPES)
def test_habits_are_shares(kind: str) -> None:
    table = habits(kind)
    assert table
    for habit in table.values():
        assert sum(habit.counts) == pytest.approx(1.0, abs=0.01)
        assert 0.0 < sum(share for _, share in habit.on) <= 1.01
        for share in (*habit.near.values(), habit.wall):
            assert 0.0 <= share <= 1.0


def test_a_draw_follows_the_counts() -> None:
    habit, rng = habits("living room")["sofa"], random.Random(0)
    drawn = Counter(habit.draw_count(rng) for _ in range(2000))
    assert drawn[0] == 0
    assert drawn[2] / 2000 == pytest.approx(habit.counts[2], abs=0.03)
    rarer = habit.rarer(0.5)
    assert rarer.counts[0] == pytest.approx(0.5)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.lists(st.booleans(), min_size=5, max_size=5), min_size=1, max_size=5))
def test_the_largest_rectangle_is_the_largest(rows: list[list[bool]]) -> None:
    mask = np.array(rows)
    r0, r1, c0, c1 = surface_stats.largest_rectangle(mask)
    assert mask[r0:r1, c0:c1].all()
    best = max(
        (a1 - a0) * (b1 - b0)
        for a0 in range(len(mask)) for a1 in range(a0, len(mask) + 1)
        for b0 in range(5) for b1 in range(b0, 6)
        if mask[a0:a1, b0:b1].all()
    )  # fmt: skip
    assert (r1 - r0) * (c1 - c0) == best


def test_a_round_top_bears_things_on_the_square_within() -> None:
    angle = np.linspace(0, 2 * np.pi, 61)
    ring = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), 0 * angle + 0.75], axis=1)
    top = np.array([[[0, 0, 0.75], a, b] for a, b in itertools.pairwise(ring)])
    size = (1.0, 1.0, 0.75)
    x0, y0, x1, y1, z = surface_stats.surface(surface_stats.height_map(top, size), size, False)  # type: ignore[misc]
    assert z == pytest.approx(1.0)
    assert 0.46 < (x1 - x0) * (y1 - y0) < 0.56, "an inscribed square has area 0.5"
    assert max(abs(v) for v in (x0, y0, x1, y1)) < 0.42


def test_a_seat_lies_below_the_back() -> None:
    def quad(x0: float, y0: float, x1: float, y1: float, z: float) -> list[list[list[float]]]:
        a, b, c, d = [x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]
        return [[a, b, c], [a, c, d]]

    sofa = np.array(quad(-1, -0.4, 1, 0.2, 0.45) + quad(-1, 0.2, 1, 0.4, 0.9))
    size = (2.0, 0.8, 0.9)
    found = surface_stats.surface(surface_stats.height_map(sofa, size), size, True)
    assert found is not None
    assert found[1] == pytest.approx(-0.5, abs=0.03)
    assert found[3] == pytest.approx(0.25, abs=0.03)
    assert found[4] == pytest.approx(0.5, abs=0.02)


def test_a_pillow_lies_on_a_bed_not_over_its_edge() -> None:
    bed = SceneObject("bed-0", "bed", "Scopia#bed1", (3.0, 2.0, 0.0), 1.57, (1.705, 2.165, 1.108))
    place = resting_place(bed)
    assert place is not None
    assert 0.3 < place.z1 < 0.8
    assert all(box_of(bed).holds(x, y, 0.01) for x, y in place.outline)
    pillow = Box(place.x, place.y, 0.4, 0.3, 0.0, place.z1, place.z1 + 0.1)
    assert lies_on(pillow, place)
    assert not lies_on(Box(place.x + 1.0, place.y, 0.4, 0.3, 0.0, place.z1, 1.0), place)
    assert not lies_on(Box(place.x, place.y, 0.4, 0.3, 0.0, place.z1 + 0.1, 1.0), place)
    picture = SceneObject("p", "picture", "builtin:picture.0", (0, 0, 1), 0.0, (0.7, 0.05, 0.5))
    assert resting_place(picture) is None


def run(*arguments: str) -> tuple[int, str]:
    done = CliRunner().invoke(generate_command, list(arguments))
    return done.exit_code, done.output


def test_generate_writes_a_scene_and_prints_counts(tmp_path: Path) -> None:
    code, out = run("--seed", "3", "--rooms", "5", "--split", "val", "--out", f"{tmp_path}/h.json")
    assert code == 0, out
    home = load_scene(tmp_path / "h.json")
    assert home == generate(3, "val", 5)
    beds = sum(obj.category == "bed" for obj in home.objects)
    assert f"| bed | {beds} | 1 |" in out


def test_generate_counts_several_by_split(tmp_path: Path) -> None:
    options = ("--count", "2", "--rooms", "4-5", "--split", "both", "--json", f"{tmp_path}/c.json")
    code, out = run(*options, "--out", f"{tmp_path}/homes")
    assert code == 0, out
    assert "| category | train: objects | homes | val: objects | homes |" in out
    assert len(list((tmp_path / "homes").glob("*.json"))) == 4
    counts = json.loads((tmp_path / "c.json").read_text())
    assert counts["train"]["bed"] >= 2
    assert f"| {sum(counts['val'].values())} | 2 |" in out.splitlines()[-1]


@pytest.mark.parametrize("rooms", ["3", "4-10", "7-5", "many", "4-", ""])
def test_rooms_that_cannot_be_are_refused(rooms: str) -> None:
    code, out = run("--rooms", rooms)
    assert code == 2
    assert "4-9" in out


def test_every_table_bed_and_sofa_has_been_measured() -> None:
    measured = json.loads(surface_stats.OUT.read_text(encoding="utf-8"))
    missing = [name for name, _ in surface_stats.wanted() if name not in measured]
    assert not missing, "run python -m hil_sim.scenes.furniture.surface_stats"
