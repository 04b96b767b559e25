"""TOML is bounded before it is parsed, and what cannot be read is one line."""

from pathlib import Path

import pytest

from runtime.errors import ConfigError
from runtime.toml_values import DOTS, FILE_BYTES, parse_toml, read_toml, unknown


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "[" * 100_000,
        "x = " + "{a=" * 5000,
        "x = " + "9" * 5000,
        ".".join(["a"] * (DOTS + 2)) + " = 1",
        "[" + ".".join(["a"] * 20_000) + "]",
        "[map\n",
    ],
)
def test_what_would_overrun_the_parser_is_no_toml(text: str, tmp_path: Path):
    with pytest.raises(ValueError, match=r"\w"):
        parse_toml(text)
    path = tmp_path / "robot.toml"
    path.write_text(text)
    with pytest.raises(ConfigError, match=r"robot\.toml: not valid TOML: ") as caught:
        read_toml(path)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_text_or_too_large_or_not_there(tmp_path: Path):
    path = tmp_path / "robot.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ConfigError, match="not valid TOML"):
        read_toml(path)
    path.write_bytes(b"#" * (FILE_BYTES + 1))
    with pytest.raises(ConfigError, match="is larger than 256 KiB"):
        read_toml(path)
    for name in ("nowhere.toml", "a\0b", "x" * 5000):
        with pytest.raises(ConfigError, match="cannot be read"):
            read_toml(tmp_path / name)


def test_a_file_as_large_as_is_taken(tmp_path: Path):
    path = tmp_path / "robot.toml"
    path.write_bytes(b"x = 1\n".ljust(FILE_BYTES, b"#"))
    assert read_toml(path) == {"x": 1}


def test_a_name_where_there_is_none_to_know_is_told_as_such():
    assert unknown("rug", ()) == "unknown; there is none"
