"""A fitted calibration goes into the file, and only that."""

import json
from pathlib import Path

import numpy as np
import onnx
import pytest

from models.detection.detector import OpenDetector, open_detector
from models.detection.fixed_list import FixedListDetector
from models.errors import ModelFileError
from models.evaluation.measures import whole_calibration
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
    for gain, must in ((float("nan"), "a finite number"), (-1, "above 0")):
        report.write_text(json.dumps({"calibration": {"gain": gain, "shift": 0}}))
        with pytest.raises(ModelFileError, match=rf"report\.json: value\.gain .* must be {must}"):
            calibrate(mine, report)
    report.write_text("{}")
    with pytest.raises(ModelFileError, match=r"report\.json: not a report"):
        calibrate(mine, report)
    report.write_text(json.dumps({"calibration": {"gain": 1, "shift": 0}}))
    with pytest.raises(ModelFileError, match="not a readable ONNX file"):
        calibrate(tmp_path / "none.onnx", report)


def test_a_fixed_list_is_calibrated_again_upon_what_it_has(
    tmp_path: Path, encoder, constant_graph
) -> None:
    out = np.zeros((1, 4 + 2, 8 * 12 + 4 * 6 + 2 * 3), np.float32)
    path = constant_graph({"out": out}, (64, 96), {"names": "['couch', 'tv']", "source": "here"})
    graph, report = onnx.load(str(path)).graph, tmp_path / "report.json"
    report.write_text(json.dumps({"calibration": {"gain": 2.5, "shift": 0.5}}))
    calibrate(path, report)
    detector = open_detector(path, "auto", encoder)
    assert isinstance(detector, FixedListDetector)
    assert (detector.gain, detector.shift) == (2.5, 0.5)
    written = onnx.load(str(path))
    assert written.graph == graph
    assert {p.key for p in written.metadata_props} == {
        "names", "source", "value.gain", "value.shift"
    }  # fmt: skip
    # what is fitted on its scores as they are now comes upon that
    assert whole_calibration(detector, 2, 1) == {"gain": 5, "shift": 2}
