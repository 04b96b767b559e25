"""What `rfnav config` prints is a configuration, and the one for robots is part of it."""

import tomllib
from pathlib import Path

from click.testing import CliRunner, Result
from places import ROOT

from runtime.__main__ import cli
from runtime.commands.config import sentence, value
from runtime.config import Config, known_keys, load

ROBOT = ROOT / "deploy" / "robot.toml"
MOST = 93


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments)


def test_the_defaults_are_printed_as_toml_that_is_the_defaults(tmp_path: Path) -> None:
    printed = run("config", "--defaults").output
    tables = tomllib.loads(printed)
    assert list(tables)[-1] == "research"
    path = tmp_path / "all.toml"
    path.write_text(printed)
    assert load(path) == Config()
    for key in known_keys().values():
        table = tables
        for part in key.name.split("."):
            table = table[part]
        assert "\n".join(sentence(key)) in printed


def test_every_key_is_explained_and_told_in_its_unit() -> None:
    units = {
        "m": "m",
        "s": "s",
        "rad": "rad",
        "radps": "rad/s",
        "mps": "m/s",
        "mps2": "m/s^2",
        "radps2": "rad/s^2",
        "hz": "Hz",
        "px": "px",
        "usd": "USD",
        "tokens": "tokens",
    }
    for key in known_keys().values():
        assert key.meaning.endswith("."), key.name
        suffix = key.name.rpartition("_")[2]
        if "_" in key.name.rpartition(".")[2] and suffix in units:
            assert key.unit == units[suffix], key.name


def test_a_robot_has_few_keys() -> None:
    own = [name for name in known_keys() if not name.startswith("research.")]
    print(f"{len(own)} keys outside of [research], fewer than {MOST} wanted")
    assert len(own) < MOST


def test_a_file_is_printed_with_what_it_leaves_out(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[robot]\nradius_m = 0.25\n")
    printed = run("config", "--config", str(path), "--set", "models.threads=1").output
    (tmp_path / "again.toml").write_text(printed)
    assert load(tmp_path / "again.toml") == load(path, ["models.threads=1"])
    assert load(path).navigate.robot.radius_m == 0.25
    assert run("config").exit_code == 2
    assert run("config", "--defaults", "--config", str(path)).exit_code == 2


def test_the_example_for_robots_is_part_of_the_defaults() -> None:
    text = ROBOT.read_text(encoding="utf-8")
    load(ROBOT)
    table, comment, seen = "", [], 0
    for line in text.splitlines():
        if line.startswith("["):
            table = line.strip("[]")
        elif line.startswith("#"):
            comment.append(line)
            continue
        elif line:
            name, _, rest = line.partition(" = ")
            key = known_keys()[f"{table}.{name}"]
            assert comment == sentence(key)
            default = value(key.default)
            assert rest == default or rest.endswith(f"  # default: {default}"), line
            seen += 1
        comment = []
    assert seen > 30
