"""Models that do not exist are found before anything is loaded."""

from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from runtime.__main__ import cli
from runtime.config import ModelsConfig
from runtime.errors import ModelError
from runtime.perception.configured_models import check_models


def test_those_that_come_with_us_exist():
    check_models(ModelsConfig())


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"language": "smolm2"}, "models.language: smolm2: no such model; known are "),
        ({"language": "/opt/models/none.gguf"}, "models.language: /opt/models/none.gguf: no such "),
        ({"detectors": ("rfnav-det", "yolo")}, "models.detectors: yolo: no such model; known are"),
        ({"detectors": ("./none.onnx",)}, "models.detectors: ./none.onnx: no such file"),
        ({"vision": "eyes"}, "models.vision: eyes: no such model; known are "),
        ({"vision_projector": "none.gguf"}, "models.vision_projector: none.gguf: no such file"),
        ({"second_look": "none"}, "research.second_look: none: no such model"),
        ({"scene_layout": "a/x.onnx"}, "research.scene_layout_file: a/x.onnx: no such file"),
        ({"vocabulary": "none.toml"}, "none.toml: not a word list"),
    ],
)
def test_one_that_does_not_is_named_with_its_key(change: dict, told: str):
    with pytest.raises(ModelError) as caught:
        check_models(replace(ModelsConfig(), **change))
    assert str(caught.value).startswith(told)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("command", ["check", "run"])
def test_they_are_told_of_by_check_and_at_the_start(command: str, tmp_path: Path):
    path = tmp_path / "robot.toml"
    path.write_text('[models]\ndetectors = ["yolo"]\n')
    done = CliRunner().invoke(cli, [command, "--config", str(path)])
    assert isinstance(done.exception, ModelError)
    assert str(done.exception).startswith("models.detectors: yolo: no such model")
