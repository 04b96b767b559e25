"""`rfnav models`: what it says, and how it ends."""

import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from runtime import __main__ as program
from runtime.perception.models_command import models_command


def test_list_and_verify(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    listing = CliRunner().invoke(models_command, ["list"])
    assert listing.exit_code == 0
    assert "not here or damaged" in listing.output
    checked = CliRunner().invoke(models_command, ["verify", "minilm"])
    assert checked.exit_code == 1
    assert "rfnav models pull minilm" in checked.output


def test_a_fault_of_a_model_is_one_line_and_status_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["rfnav", "models", "pull", "nonesuch"])
    with pytest.raises(SystemExit) as ended:
        program.main()
    assert ended.value.code == 2
    told = capsys.readouterr().err
    assert told.startswith("rfnav: nonesuch: no such model; known are ")
    assert told.count("\n") == 1
