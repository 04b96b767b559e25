"""A fitted calibration goes into the file, and only that."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("torch")

from models.detection.detector import OpenDetector, open_detector
from models.errors import ModelFileError
from models.store import manifest
from models.train.calibrate import calibrate


def test_gain_and_shift_go_into_the_file(tmp_path: Path, encoder, constant_graph) -> None:
    theirs = Path(manifest.PACKAGE) / "weights" / "rfnav-det.onnx"
    mine, report = tmp_path / "det.onnx", tmp_path / "report.json"
    mine.write_bytes(theirs.read_bytes())
    report.write_text(json.dumps({"calibration": {"gain": 1.25, "shift": -0.5}}))
    calibrate(mine, report)
    before, after = (open_detector(p, "auto", encoder) for p in (theirs, mine))
    assert isinstance(before, OpenDetector)
    assert isinstance(after, OpenDetector)
    assert (after.gain, after.shift) == (1.25, -0.5)
    assert after.size == before.size
    with pytest.raises(ModelFileError, match="not an RF-NAV detector"):
        calibrate(constant_graph({"out": np.zeros((1, 2))}, (32, 32)), report)
    report.write_text("{}")
    with pytest.raises(ModelFileError, match=r"report\.json: not a report"):
        calibrate(mine, report)
    report.write_text(json.dumps({"calibration": {"gain": 1, "shift": 0}}))
    with pytest.raises(ModelFileError, match="not a readable ONNX file"):
        calibrate(tmp_path / "none.onnx", report)
