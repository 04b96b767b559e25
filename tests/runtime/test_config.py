"""Configuration: defaults, files, overrides, and one clear line for each mistake."""

from pathlib import Path

import pytest

from runtime.config import Config, load
from runtime.errors import ConfigError


def test_no_file_is_the_defaults():
    assert load(None) == Config()


def test_a_file_reaches_its_module_and_settings_win(tmp_path: Path):
    path = tmp_path / "robot.toml"
    path.write_text(
        '[map]\nmax_depth_m = 3\n[panel]\nexperts = ["o2f"]\n[bus]\nprefix = "rosie"\n'
        '[research]\nconsensus_mode = "weighted"\nconsensus_weights = [["o2f", 2.0]]\n'
    )
    config = load(path, ["panel.decide_budget_s=0.5", "research.consensus_mode=lenient"])
    assert config.navigate.map.max_depth_m == 3.0
    assert config.panel.experts == ("o2f",)
    assert config.panel.decide_budget_s == 0.5
    assert config.navigate.consensus.mode == "lenient"
    assert config.navigate.consensus.weights == (("o2f", 2.0),)
    assert config.bus.prefix == "rosie"


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("map.max_detph_m=0.1", "map.max_detph_m: unknown; did you mean max_depth_m?"),
        ("mpa.stride=1", "mpa: unknown; did you mean map?"),
        ("bus.topics.colour='x'", "bus.topics.colour: unknown; did you mean color?"),
        ("planner.velocity=1", "planner: unknown; "),
        ("consensus.mod=1", "consensus.mod: unknown; did you mean research.consensus_mode?"),
        ("research.consensus=1", "research.consensus: unknown; did you mean consensus_"),
        ("models.threads=2.5", "models.threads: is 2.5, must be of type int"),
        ("map.max_depth_m=true", "map.max_depth_m: is True, must be of type float"),
        ("map.max_depth_m.x=1", "map.max_depth_m: is {'x': 1}, must be of type float"),
        ("map=3", "map: must be a table"),
        ("panel.experts=['o2f','r2d2']", "panel.experts: unknown; did you mean r2f?"),
        ("bus.mode=boss", "bus.mode: unknown; known are client, peer"),
        ("bus.mode=3", "bus.mode: is 3, must be of type str"),
        ("research.consensus_rank=first", "research.consensus_rank: unknown"),
        ("research.consensus_weights=[3]", "research.consensus_weights: "),
        ("research.consensus_detour_m=-0.1", "consensus_detour_m: is -0.1, must be 0 m or more"),
        ("research.consensus_detour_m=nan", "consensus_detour_m: is nan, must be 0 m or more"),
        ("robot.radius_m=0.0", "robot.radius_m: is 0.0, must be 0.03 to 1.5 m"),
        ("safety.odom_stale_s=inf", "safety.odom_stale_s: is inf, must be 0.05 to 2 s"),
        ("control.brake_mps2=1e9", "control.brake_mps2: is 1000000000.0, must be 0.05 to 10 m/s"),
        ("control.max_turn_radps=30", "is 30.0, must be 0.05 to 6 rad/s; 30 degrees/s are 0.524"),
        ("camera.pitch_rad=-90", "is -90.0, must be -1.6 to 1.6 rad; -90 degrees are -1.57 rad"),
        ("camera.z_m=-0.4", "camera.z_m: is -0.4, must be 0.02 to 3 m"),
        ("camera.z_m=880", "camera.z_m: is 880.0, must be 0.02 to 3 m; 880 mm are 0.88 m"),
        ("robot.radius_m=180", "is 180.0, must be 0.03 to 1.5 m; 180 mm are 0.18 m"),
        ("camera.depth_unit_m=1000", "is 1000.0, must be 0 to 1 m; 1000 mm are 1 m"),
        ("camera.depth_nothing_m=4000", "is 4000.0, must be 0 to 100 m; 4000 mm are 4 m"),
        ("camera.z_m=nan", "camera.z_m: is nan, must be 0.02 to 3 m"),
        ("models.threads=1000000", "models.threads: is 1000000, must be 1 to 64"),
        (f"models.threads={'9' * 300}", "models.threads: is too large"),
        ("cloud.cap_day_usd=-1.0", "cloud.cap_day_usd: is -1.0, must be 0 to 1e+06 USD"),
        ("research.cloud_timeout_s=0.0", "research.cloud_timeout_s: is 0.0, must be 0.1 to 600 s"),
        ("nonsense", "must be KEY=VALUE"),
    ],
)
def test_a_mistake_is_one_line_that_names_the_key(setting: str, message: str):
    with pytest.raises(ConfigError) as caught:
        load(None, [setting])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_all_values_that_cannot_be_are_told_at_once():
    with pytest.raises(ConfigError) as caught:
        load(None, ["camera.z_m=-0.4", "camera.pitch_rad=-90", "robot.radius_m=0.2"])
    assert str(caught.value) == (
        "camera.z_m: is -0.4, must be 0.02 to 3 m; "
        "camera.pitch_rad: is -90.0, must be -1.6 to 1.6 rad; -90 degrees are -1.57 rad"
    )


def test_files_that_cannot_be_used_are_named(tmp_path: Path):
    with pytest.raises(ConfigError, match=r"nowhere\.toml: cannot be read"):
        load(tmp_path / "nowhere.toml")
    (tmp_path / "broken.toml").write_text("[map\n")
    with pytest.raises(ConfigError, match=r"broken\.toml: not valid TOML"):
        load(tmp_path / "broken.toml")


def test_a_share_of_a_cloud_is_looked_at():
    with pytest.raises(ConfigError, match=r"research\.cloud_local_share: is 1\.5, must be 0 to 1"):
        load(None, ["research.cloud_local_share=1.5"])


def test_evidence_is_not_left_out_in_silence():
    prior, closest = 'research.consensus_mode="prior"', 'research.consensus_fallback="closest"'
    with pytest.raises(ConfigError, match=r'must be "geometry" or "ahead"'):
        load(None, [prior, closest])
    assert load(None, [prior]).navigate.consensus.fallback == "ahead"
    assert load(None, [prior, closest, "panel.experts=[]"]).panel.experts == ()
