"""`rfnav models`: what it says, and how it ends."""

import sys
from pathlib import Path

import cv2
import pytest
from click.testing import CliRunner

from models.detection.trial import RENDERS
from models.evaluation.sheet import GAP, HEIGHT, WIDTH
from models.store import manifest
from runtime import __main__ as program
from runtime.errors import ModelError
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


def test_a_licence_that_is_not_accepted_is_one_line_and_status_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(sys, "argv", ["rfnav", "models", "pull", "lfm2.5-vl-450m"])
    with pytest.raises(SystemExit) as ended:
        program.main()
    assert ended.value.code == 2
    told = capsys.readouterr().err
    assert told.startswith("rfnav: lfm2.5-vl-450m: its licence is lfm1.0 (https://")
    assert told.count("\n") == 1


def test_what_only_training_needs_is_pulled_with_all(monkeypatch: pytest.MonkeyPatch) -> None:
    pulled: list[str] = []
    monkeypatch.setattr(manifest, "fetch", lambda name, *_, **__: pulled.append(name))
    CliRunner().invoke(models_command, ["pull", "--all"], catch_exceptions=False)
    assert {"efficientnet-lite0", "imagenet-names", "minilm"} <= set(pulled)
    assert {"smolvlm2-500m", "d-fine-n", "lfm2.5-vl-450m"}.isdisjoint(pulled)


def test_what_sees_nothing_is_not_tried() -> None:
    for arguments, told in (
        (["minilm"], "minilm: is a model for text, and neither sees nor votes"),
        (["experts", "--sheet", "x.png"], "experts: votes, and finds no boxes; leave out --sheet"),
    ):
        with pytest.raises(ModelError, match=told):
            CliRunner().invoke(models_command, ["try", *arguments], catch_exceptions=False)


@pytest.mark.slow
def test_a_detector_shows_what_it_sees(tmp_path: Path) -> None:
    sheet = tmp_path / "sheet.png"
    arguments = ["try", "nanodet-g", str(RENDERS[0]), "--sheet", str(sheet), "--limit-s", "120"]
    done = CliRunner().invoke(models_command, arguments, catch_exceptions=False)
    assert done.exit_code == 0
    lines = done.output.splitlines()
    assert lines[1].startswith("  HM3D's goals: 6 of 6: chair, sofa (by couch), plant (by potted")
    assert lines[2].startswith("  RoboTHOR's goals: 7 of 12: apple")
    assert "    not seen: alarm clock, basketball, trash can, mug, spray bottle" in lines
    assert any(line.startswith("bathroom.jpg: toilet 0.") for line in lines)
    assert [line for line in lines if line.startswith("living-room.jpg: ")][1:]
    picture = cv2.imread(str(sheet))
    assert picture.shape == (HEIGHT + GAP, 4 * (WIDTH + GAP), 3)
