"""Configuration: defaults, files, overrides, and one clear line for each mistake."""

from dataclasses import replace
from pathlib import Path

import pytest
from places import ROOT

from runtime.config import Config, load
from runtime.errors import ConfigError


def test_no_file_is_the_defaults():
    assert load(None) == Config()


def test_a_file_reaches_its_module_and_settings_win(tmp_path: Path):
    path = tmp_path / "robot.toml"
    path.write_text('[map]\nside_m = 30\n[panel]\nexperts = ["o2f"]\n[bus]\nprefix = "rosie"\n')
    config = load(path, ["panel.decide_budget_s=0.5", "consensus.mode=lenient"])
    assert config.navigate.map.side_m == 30.0
    assert config.panel.experts == ("o2f",)
    assert config.panel.decide_budget_s == 0.5
    assert config.navigate.consensus.mode == "lenient"
    assert config.bus.prefix == "rosie"


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("map.resolutoin_m=0.1", "map.resolutoin_m: unknown; did you mean resolution_m?"),
        ("mpa.stride=1", "mpa: unknown; did you mean map?"),
        ("bus.topics.colour='x'", "bus.topics.colour: unknown; did you mean color?"),
        ("map.stride=2.5", "map.stride: is 2.5, must be of type int"),
        ("map.side_m=true", "map.side_m: is True, must be of type float"),
        ("map=3", "map: must be a table"),
        ("panel.experts=['o2f','r2d2']", "panel.experts: unknown; did you mean r2f?"),
        ("consensus.rank=first", "consensus.rank: unknown"),
        ("consensus.detour_m=-0.1", "consensus.detour_m: is -0.1, must be 0 or more"),
        ("consensus.detour_m=nan", "consensus.detour_m: is nan, must be 0 or more"),
        ("map.resolution_m=0.0", "map.resolution_m: is 0.0, must be more than 0"),
        ("nonsense", "must be KEY=VALUE"),
    ],
)
def test_a_mistake_is_one_line_that_names_the_key(setting: str, message: str):
    with pytest.raises(ConfigError) as caught:
        load(None, [setting])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_used_are_named(tmp_path: Path):
    with pytest.raises(ConfigError, match=r"nowhere\.toml: cannot be read"):
        load(tmp_path / "nowhere.toml")
    (tmp_path / "broken.toml").write_text("[map\n")
    with pytest.raises(ConfigError, match=r"broken\.toml: not valid TOML"):
        load(tmp_path / "broken.toml")


def test_the_example_for_robots_is_the_defaults_but_for_its_bus():
    config = load(ROOT / "deploy" / "robot.toml")
    assert config.bus.mode == "client"
    assert replace(config, bus=Config().bus) == Config()
