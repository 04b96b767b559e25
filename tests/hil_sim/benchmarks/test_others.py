"""Others' code is looked for where somebody has it."""

from pathlib import Path

import pytest
from apartment import MOUNT, TWO_ROOMS, Apartment

from hil_sim.benchmarks import drive, others
from runtime import navigate
from runtime.core.types import Pose
from runtime.errors import ConfigError

PLANNER = """
class FMMPlanner:
    def __init__(self, traversible): self.shape = traversible.shape
    def set_multi_goal(self, goal): assert goal.shape == self.shape
    def get_short_term_goal(self, state): return state
"""


def test_a_checkout_that_is_not_there_is_told(tmp_path: Path):
    world = drive.begin(drive.configuration())
    with pytest.raises(ConfigError, match="no such folder"):
        others.semexp(tmp_path / "nowhere", world)


def test_a_planner_of_that_name_is_timed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("sys.path", list(__import__("sys").path))
    folder = tmp_path / "envs" / "utils"
    folder.mkdir(parents=True)
    (folder / "fmm_planner.py").write_text(PLANNER)
    config, home = drive.configuration(), Apartment.of(TWO_ROOMS, Pose(1.0, 3.2, 0.0))
    world, obs = drive.begin(config), home.observe()
    navigate.perceive(world, obs, home.detect((), obs), MOUNT, config.navigate)
    assert len(others.semexp(tmp_path, world, times=3)) == 3
