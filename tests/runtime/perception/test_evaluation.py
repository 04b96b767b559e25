"""`rfnav models evaluate`, on drawn frames and a detector whose answers are known."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from labelled_frames import SOFA, sofa_graph, write_frames
from places import ROOT

pytest.importorskip("pycocotools")

from models.detection import second_look
from models.errors import ModelFileError
from models.evaluation.truth import read_words
from models.words.text_encoder import TextEncoder
from runtime.config import DetectorConfig
from runtime.errors import ModelError
from runtime.perception.models_command import models_command

pytestmark = pytest.mark.slow  # the real models are loaded


def run(*arguments: object) -> str:
    done = CliRunner().invoke(models_command, list(map(str, arguments)), catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


@pytest.fixture
def frames(tmp_path: Path) -> tuple[Path, Path]:
    """To judge on, six sofas, a toilet and a guitar, and to fit on."""
    data, dev = tmp_path / "val", tmp_path / "dev"
    write_frames(
        data,
        [[tuple(SOFA)] for _ in range(6)]
        + [[], [(2, [60, 30, 20, 20], 0), (3, [0, 0, 20, 30], 0)]],
    )
    write_frames(dev, [[tuple(SOFA)], []])
    return data, dev


def test_a_detector_is_asked_as_the_runtime_would(
    frames: tuple[Path, Path], constant_graph, encoder: TextEncoder, tmp_path: Path
) -> None:
    data, dev = frames
    path, figures = sofa_graph(constant_graph, encoder), tmp_path / "figures.json"
    text = run(
        "evaluate", "--data", data, "--dev", dev, "--detector", path, "--no-cost",
        "--json", figures, "--threads", 1,
    )  # fmt: skip
    report = json.loads(figures.read_text())
    assert report["frames"] == 8
    assert report["fitted_on_other_frames"]
    rows = report["synonyms"]["rows"]
    assert {row["synonym"] for row in rows} == set(read_words().unseen["sofa"])
    assert {row["as"] for row in rows} == {"sofa"}  # the dictionary and the list know them
    assert report["synonyms"]["understood_mean"] > report["synonyms"]["mean"]
    assert {row["category"] for row in report["asked"]["rows"]} == {"sofa"}
    twice = report["second_look"]
    assert twice["of"] == len(read_words().held_out)
    assert {name: row["as"] for name, row in twice["categories"].items()} == {"guitar": "guitar"}
    assert twice["categories"]["guitar"]["objects"] == 1
    assert f"other names ({len(report['asked']['rows'])}): share of own AP" in text
    assert "cost" not in report


@pytest.mark.slow
def test_less_is_judged_when_less_is_asked(
    frames: tuple[Path, Path], constant_graph, encoder: TextEncoder
) -> None:
    data, _ = frames
    path = sofa_graph(constant_graph, encoder)
    text = run(
        "evaluate", "--data", data, "--detector", path, "--limit", 3, "--no-cost", "--no-synonyms"
    )
    assert "3 frames." in text
    assert "fitted on these same frames" in text
    assert "share of own AP" not in text
    assert "held out, looked at twice" in text


def test_a_sheet_is_drawn_and_nothing_is_measured(
    frames: tuple[Path, Path], constant_graph, encoder: TextEncoder, tmp_path: Path
) -> None:
    sheet = tmp_path / "sheet.png"
    path = sofa_graph(constant_graph, encoder)
    said = run("evaluate", "--data", frames[0], "--detector", path, "--sheet", sheet)
    assert said == f"{sheet}: detections of {path.name} on {frames[0]}\n"
    assert sheet.is_file()


def test_frames_that_are_none_are_told_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"annotations\.json: not a readable COCO table") as caught:
        run("evaluate", "--data", tmp_path)
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value.__cause__, ModelFileError)


def test_a_robot_that_lacks_what_judges_is_told_what_to_install(tmp_path: Path) -> None:
    """Nothing else of `rfnav` needs it."""
    code = (
        "import sys; sys.modules['pycocotools'] = None; from runtime.__main__ import main; "
        f"sys.argv = ['rfnav', 'models', 'evaluate', '--data', {str(tmp_path)!r}]; main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=False
    )
    assert done.returncode == 2
    assert done.stderr == (
        "rfnav: models evaluate: pycocotools is not installed; it comes with the extra `train`\n"
    )


def test_the_second_look_is_fitted_with_as_many_places_as_the_robot_looks_at() -> None:
    assert second_look.LOOKS == DetectorConfig().second_looks <= second_look.PLACES
