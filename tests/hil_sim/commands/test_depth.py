"""`hil-sim depth`: which maps are made, and the table of what they are worth."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from click.testing import CliRunner

from hil_sim.commands import depth
from hil_sim.evaluation.depth_maps import MapCase, MapScore
from hil_sim.simulation.depth_cameras import CAMERAS
from hil_sim.simulation.noise import parse_noise


def test_every_camera_is_mapped_with_flying_pixels_and_without() -> None:
    still = depth.cases(sways=False)
    assert len(set(still)) == len(still) == 2 * (2 + len(CAMERAS))
    assert {case.mount for case in still} == {"fixed"}
    for case in still:
        parse_noise([case.noise])
        assert MapCase(case.noise, not case.drops) in still


def test_a_camera_that_sways_is_mapped_by_each_way_to_know_its_mount() -> None:
    swaying = depth.cases(sways=True)
    assert all(case.drops for case in swaying)
    assert {case.noise for case in swaying} == {"none", *(f"camera={name}" for name in CAMERAS)}
    for case in swaying:
        mounts = [other.mount for other in swaying if other.noise == case.noise]
        assert mounts == ["fixed", "floor", "tf"]


def test_a_line_has_the_shares_of_its_case() -> None:
    score = MapScore(floor=200, kept=190, false=5, obstacles=40, missed=1)
    head, rule, line = depth.lines({MapCase("flying=1", True, "tf"): score})
    assert line == "| flying=1 | dropped | tf | 95.0 % | 2.5 % | 2.5 % |"
    assert head.count("|") == rule.count("|") == line.count("|")


def test_places_are_added_up_and_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[list[str], int, bool, int]] = []

    def compare(
        homes: list[str], places: int, cases: Sequence[MapCase], sways: bool, seed: int
    ) -> Iterator[dict[MapCase, MapScore]]:
        asked.append((homes, places, sways, seed))
        for k in range(2):
            yield dict.fromkeys(cases, MapScore(floor=100, kept=90 + k, obstacles=10, missed=k))

    monkeypatch.setattr(depth, "compare", compare)
    out = tmp_path / "depth.json"
    command = ["--homes", "maple, oak", "--places", "1", "--sways", "--json", str(out)]
    done = CliRunner().invoke(depth.depth_command, command, catch_exceptions=False)
    assert asked == [(["maple", "oak"], 1, True, 0)]
    assert "| camera=kinect-v1 | dropped | floor | 90.5 % | 0.0 % | 5.0 % |" in done.output
    told = json.loads(out.read_text())
    assert [(row["mount"], row["floor"], row["kept"]) for row in told][:2] == [
        ("fixed", 200, 181), ("floor", 200, 181),
    ]  # fmt: skip
