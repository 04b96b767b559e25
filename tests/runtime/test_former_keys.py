"""Keys of before: each is still there, renamed, or told to be a constant that has its value."""

import importlib
import tomllib
from pathlib import Path

import pytest

from runtime.config import _tell, known_keys, load
from runtime.errors import ConfigError
from runtime.former_keys import FORMER, GONE, LISTED, REMOVED, RENAMED, modern

BEFORE = tomllib.loads(Path(__file__).with_name("keys_before.toml").read_text(encoding="utf-8"))
CHANGED = {"consensus.fallback": "ahead", "consensus.mode": "prior"}
"""Since then on purpose; see docs/searching.md."""
CONSTANTS = {key: (file, name) for file, names in GONE.items() for key, name in names.items()}


def as_toml(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value


def test_every_key_of_before_has_a_place() -> None:
    lost = set(BEFORE) - set(known_keys()) - FORMER
    assert not lost
    assert set(BEFORE) >= FORMER
    assert not FORMER & set(known_keys())
    assert not set(RENAMED) & set(CONSTANTS)


@pytest.mark.parametrize("key", sorted(set(BEFORE) - LISTED - set(REMOVED)))
def test_its_default_is_what_it_was(key: str) -> None:
    if key in CONSTANTS:
        file, name = CONSTANTS[key]
        module = importlib.import_module(file.removesuffix(".py").replace("/", "."))
        found = getattr(module, name)
    else:
        found = known_keys()[RENAMED.get(key, key)].default
    assert as_toml(found) == CHANGED.get(key, BEFORE[key])
    assert type(as_toml(found)) is type(BEFORE[key])


def test_a_renamed_key_goes_on_working_and_names_its_successor_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _tell.cache_clear()
    path = tmp_path / "robot.toml"
    path.write_text('[consensus]\nmode = "lenient"\n[models]\nscore_file = "s"\nthreads = 1\n')
    for _ in range(2):
        config = load(path, ["experts.bar=1.25"])
        assert config.navigate.consensus.mode == "lenient"
        assert (config.models.score_file, config.models.threads) == ("s", 1)
        assert config.experts.bar == 1.25
    assert capsys.readouterr().err.splitlines() == [
        "rfnav: consensus.mode: is called research.consensus_mode now",
        "rfnav: models.score_file: is called research.score_file now",
        "rfnav: experts.bar: is called research.experts_bar now",
    ]


def test_a_key_that_went_away_names_its_constant(tmp_path: Path) -> None:
    path = tmp_path / "robot.toml"
    path.write_text("[planner]\nmargin_m = 0.05\n")
    with pytest.raises(ConfigError) as caught:
        load(path)
    assert str(caught.value) == (
        f"{path}: planner.margin_m: cannot be set any more; it is the constant MARGIN_M in "
        "runtime/core/distances/terrain.py"
    )


def test_settings_of_before_by_the_names_of_today() -> None:
    assert modern('consensus.mode="best"') == 'research.consensus_mode="best"'
    assert modern("models.threads=1") == "models.threads=1"
    assert modern("nonsense") == "nonsense"
