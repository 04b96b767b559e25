"""Which base, and what is refused in a line."""

import pytest
from click.testing import CliRunner

from runtime.__main__ import cli
from runtime.config import load
from runtime.errors import ConfigError


def test_ros2_and_differential_unless_told_otherwise():
    base = load(None).base
    assert (base.kind, base.drive, base.odometry) == ("ros2", "differential", False)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (["base.drive=holonomic"], 'base.drive: "holonomic": a base that moves sideways'),
        (["base.drive=ackermann"], 'base.drive: "ackermann": car-like steering cannot turn'),
        (["base.drive=legs"], "configuration: base.drive: unknown; "),
        (["base.kind=mavlink", "base.link=COM3"], "base.link: 'COM3' is no address: e.g. "),
        (["base.odometry=true"], 'base.odometry: only a base of kind "mavlink" brings its own'),
        (
            ["base.kind=mavlink", "base.odometry=true", 'bus.topics.pose="pose"'],
            "base.odometry: bus.topics.pose is set too",
        ),
    ],
)
def test_a_base_that_would_be_driven_wrongly_is_refused(settings: list[str], message: str):
    with pytest.raises(ConfigError) as told:
        load(None, settings)
    assert str(told.value).startswith(message)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("more", [[], ["--lockstep"], ["--lockstep", "--set", "base.kind=mavlink"]])
def test_only_what_can_be_armed_may_be(more: list[str]):
    with pytest.raises(ConfigError, match=r"^--arm: only a base of kind mavlink, in real time"):
        CliRunner().invoke(cli, ["run", "--arm", *more], catch_exceptions=False)


def test_a_base_is_refused_when_it_is_checked(tmp_path):
    path = tmp_path / "robot.toml"
    path.write_text('[base]\ndrive = "ackermann"\n')
    with pytest.raises(ConfigError, match="car-like steering"):
        CliRunner().invoke(cli, ["check", "--config", str(path)], catch_exceptions=False)
