"""Figures of merit, on drawn frames and a detector whose answers are known."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from labelled_frames import SOFA, sofa_graph, write_frames

pytest.importorskip("pycocotools")

from models.detection.detections import RawDetections
from models.detection.detector import OpenDetector, open_detector
from models.errors import ModelFileError
from models.evaluation import judged as judging
from models.evaluation.asked import LookedFor, by_other_names
from models.evaluation.measures import measure, room_accuracy, tried
from models.evaluation.naming import look
from models.evaluation.precision import Precision
from models.evaluation.report import markdown
from models.evaluation.sheet import COLUMNS, GAP, HEIGHT, ROWS, WIDTH, draw_sheet
from models.evaluation.truth import FrameTruth, read_truth, read_words
from models.words.text_encoder import TextEncoder

ROOMS = ("kitchen", "bathroom")


@pytest.fixture
def truth(tmp_path: Path) -> FrameTruth:
    """Ten frames; a sofa in the first eight, one of them too hidden to count."""
    notes = [[tuple(SOFA)] for _ in range(7)] + [[(1, [10, 10, 50, 40], 1)]]
    return write_frames(tmp_path / "frames", [*notes, [], [(2, [60, 30, 20, 20], 0)]])


@pytest.fixture
def detector(constant_graph, encoder: TextEncoder) -> OpenDetector:
    """It sees a sofa, whatever it is shown."""
    found = open_detector(sofa_graph(constant_graph, encoder), "auto", encoder)
    assert isinstance(found, OpenDetector)
    return found


def seen(*rows: tuple[int, float, tuple[float, ...]]) -> RawDetections:
    boxes = np.array([r[2] for r in rows], np.float32).reshape(-1, 4)
    scores, labels = np.array([r[1] for r in rows], np.float32), np.array([r[0] for r in rows], int)
    nothing = np.zeros(0, np.float32)
    return RawDetections(boxes, scores, labels, np.zeros((len(rows), 0)), nothing, nothing)


def test_average_precision_of_hits_misses_and_ignored_ones(truth: FrameTruth) -> None:
    box = (10.0, 10.0, 60.0, 50.0)
    everywhere = [seen((0, 0.9 if k < 7 else 0.95, box)) for k in range(10)]
    ap = Precision(truth).average(everywhere, range(3))
    assert ap.keys() == {0, 1}  # no guitar counts
    # two wrong ones before seven right ones; on the hidden sofa a detection is neither
    assert ap[0] == pytest.approx(7 / 9)
    assert ap[1] == 0
    nowhere = [seen() for _ in truth.marks]
    assert Precision(truth).average(nowhere, [0]) == {0: 0.0}
    right = [seen((0, 0.9, box)) if k < 7 else seen() for k in range(10)]
    assert Precision(truth).average(right, [0]) == {0: pytest.approx(1)}


def test_the_interval_of_a_mean_is_that_of_frames_drawn_anew(truth: FrameTruth) -> None:
    box = (10.0, 10.0, 60.0, 50.0)
    right = [seen((0, 0.9, box)) if k < 7 else seen() for k in range(10)]
    groups = {"sofas": [0], "both": [0, 1], "guitars": [2]}
    found = Precision(truth).intervals(right, groups)
    assert found["sofas"] == (1.0, 1.0)  # whatever is drawn
    assert found["both"] == (0.5, 1.0)  # of half of the draws the toilet is no part
    assert np.isnan(found["guitars"]).all()  # none counts
    half = [seen((0, 0.9, box)) if k < 3 else seen() for k in range(10)]
    low, high = Precision(truth).intervals(half, {"sofas": [0]})["sofas"]
    assert 0 <= low < Precision(truth).average(half, [0])[0] < high < 1
    nowhere = Precision(truth).intervals([seen() for _ in range(10)], groups)
    assert (nowhere["sofas"], nowhere["both"]) == ((0.0, 0.0), (0.0, 0.0))
    assert np.isnan(nowhere["guitars"]).all()


def test_what_is_not_boxed_throughout_is_not_judged(truth: FrameTruth) -> None:
    path = truth.directory / "annotations.json"
    table = json.loads(path.read_text())
    path.write_text(json.dumps(table | {"info": {"labelled": [truth.categories[0]]}}))
    read = read_truth(truth.directory)
    assert read.categories == truth.categories[:1]
    assert {int(k) for marks in read.marks for k in marks.kinds} == {0}
    path.write_text(json.dumps(table | {"info": {"labelled": []}}))
    assert read_truth(truth.directory).categories == ()


def test_frames_whose_room_alone_is_known_are_judged_by_that(
    truth: FrameTruth, detector: OpenDetector, encoder: TextEncoder
) -> None:
    path = truth.directory / "annotations.json"
    table = json.loads(path.read_text())
    path.write_text(json.dumps(table | {"info": {"labelled": []}}))
    words = replace(read_words(), rooms=ROOMS)
    report = measure(tried(detector, read_truth(truth.directory), None, words, encoder), words)
    assert 0 <= report["room_top1"] <= 1
    assert np.isnan(report["groups"]["HM3D goals"]["ap50"])
    assert "room type, top-1" in markdown(report)


def test_rooms_are_asked_of_all_views_and_of_those_that_show_a_thing(truth: FrameTruth) -> None:
    rooms = ("kitchen", "bathroom")
    likeliest = [1] * 6 + [0] * 4  # right where the sofa counts, but once
    assert room_accuracy(truth, likeliest, rooms) == pytest.approx(6 / 10)
    assert room_accuracy(truth, likeliest, rooms, things=True) == pytest.approx(6 / 8)
    assert np.isnan(room_accuracy(truth, likeliest, ("kitchen",)))


def test_false_sightings_count_frames_without_the_goal_only(truth: FrameTruth) -> None:
    box = (10.0, 10.0, 60.0, 50.0)
    found = [seen((0, 0.905 if k < 9 else 0.4, box)) for k in range(10)]
    absent = judging.without(truth, [0])
    assert absent.tolist() == [False] * 8 + [True, True]
    scores = judging.best_scores(found, 0)
    assert judging.false_seen(scores, absent, 0.5) == 500
    assert judging.false_seen(scores, absent, 0.95) == 0
    assert judging.choose_threshold([(scores, absent)]) == pytest.approx(0.91)


def test_calibration_makes_a_score_the_share_that_is_right() -> None:
    rng = np.random.default_rng(0)
    p = rng.uniform(0.02, 0.98, 20_000)
    right = rng.uniform(size=len(p)) < p
    sure = 1 / (1 + np.exp(-3 * np.log(p / (1 - p)) - 1))  # scores that claim too much
    judged = judging.Judged(sure, right, np.zeros(len(p), int), np.array([1]))
    assert judging.calibration_error(judged) > 0.08
    gain, shift = judging.fit_calibration(judged)
    assert judging.calibration_error(judged.recalibrated(gain, shift)) < 0.02
    assert (gain, shift) == (pytest.approx(1 / 3, abs=0.05), pytest.approx(-1 / 3, abs=0.05))


def test_a_frame_is_looked_at_once_and_named_as_the_detector_would(
    truth: FrameTruth, detector: OpenDetector, encoder: TextEncoder
) -> None:
    looked = look(detector, truth, encoder, list(ROOMS))
    plain = detector.detect(np.full((64, 96, 3), 90, np.uint8))
    for mine in looked.found:
        np.testing.assert_allclose(mine.boxes_px, plain.boxes_px)
        np.testing.assert_allclose(mine.scores, plain.scores, rtol=1e-5)
        assert mine.labels.tolist() == plain.labels.tolist()
    assert set(looked.rooms) == {1}
    (other,) = {f.labels.tolist()[0] for f in looked.with_names(0, encoder.embed(["sofa"]))}
    assert other == 0
    detector.set_vocabulary((("giraffe",), ("toilet",), ("guitar",)), ROOMS)
    renamed = detector.detect(np.full((64, 96, 3), 90, np.uint8))
    odd = looked.with_names(0, encoder.embed(["giraffe"]))[0]
    assert odd.labels.tolist() == renamed.labels.tolist()
    np.testing.assert_allclose(odd.scores, renamed.scores, rtol=1e-2)


def test_the_report_has_every_figure(
    truth: FrameTruth, detector: OpenDetector, encoder: TextEncoder, tmp_path: Path
) -> None:
    dev = write_frames(tmp_path / "dev", [[tuple(SOFA)], []])
    trial, words = tried(detector, truth, dev, read_words(), encoder), read_words()
    report = measure(trial, words)
    sofa = report["groups"]["HM3D goals"]
    assert (sofa["categories"], sofa["of"]) == (2, 6)
    assert report["room_top1"] == 1
    assert report["goals"]["sofa"]["recall"] in (0, 1)
    assert report["goals"]["sofa"]["frames_without"] == 2
    text = markdown(report)
    assert "AP50, HM3D goals (2 of 6 categories)" in text
    assert "fitted on other frames" in text
    assert "share of own AP" not in text


def test_what_a_frame_costs_is_told_where_it_was_measured(
    truth: FrameTruth, detector: OpenDetector, encoder: TextEncoder
) -> None:
    words = read_words()
    report = measure(tried(detector, truth, None, words, encoder), words)
    assert "ms a " not in markdown(report)
    one = {
        "ms": 65.4,
        "mean_ms": 66.0,
        "least_ms": 60.1,
        "cpu_ms": 64.0,
        "ratio": 1.5,
        "memory_mb": 99.6,
    }
    two = {**one, "ms": 43.2, "twice_ms": 100.4, "twice_memory_mb": 110.2}
    cost = {"bytes": 7_100_000, "threads_1": one, "threads_2": two}
    lines = markdown(report | {"cost": cost}).splitlines()
    assert (
        "| ms a 640x480 frame, 1 thread(s) | 65.4 (mean 66.0, least 60.1, ratio 1.50, CPU 64.0) "
        "| ≤ 60 |" in lines
    )
    assert "| ms a frame looked at twice, 2 thread(s) | 100.4 (110 MB more) | – |" in lines
    assert not any("twice, 1 thread" in line for line in lines)
    assert "| file, MB | 7.1 | ≤ 12 |" in lines
    assert "| memory, MB | 100 | ≤ 150 |" in lines


def test_a_name_is_worth_what_it_is_understood_as(
    truth: FrameTruth, detector: OpenDetector, encoder: TextEncoder
) -> None:
    """By its bare word a couch is hardly a sofa here; understood as one it is found as often."""
    words = replace(read_words(), unseen={"sofa": ("couch", "gravel")}, asked={"sofa": ("divan",)})
    trial = tried(detector, truth, None, words, encoder)
    assert trial.looked is not None

    def understand(text: str) -> LookedFor:
        return LookedFor(("guitar",) if text == "gravel" else ("sofa", text), strange=False)

    told = by_other_names(trial, trial.looked, words, encoder, understand)
    rows = {row["synonym"]: row for row in told["synonyms"]["rows"]}
    assert rows["couch"]["as"] == "sofa"
    assert rows["couch"]["understood_ratio"] == pytest.approx(1)
    assert rows["gravel"]["as"] == "guitar"
    assert rows["gravel"]["understood_ratio"] < 1
    assert told["synonyms"]["understood_mean"] == pytest.approx(
        np.mean([row["understood_ratio"] for row in rows.values()])
    )
    assert told["asked"]["understood_mean"] == pytest.approx(1)
    assert told["synonyms"]["left_out"] == 0
    text = markdown(measure(trial, words) | told)
    assert "other names (1): share of own AP" in text


@pytest.mark.slow
def test_a_sheet_is_drawn(truth: FrameTruth, detector: OpenDetector, tmp_path: Path) -> None:
    draw_sheet(detector, truth, read_words(), tmp_path / "sheet.png")
    sheet = cv2.imread(str(tmp_path / "sheet.png"))
    rows = -(-min(len(truth.marks), COLUMNS * ROWS) // COLUMNS)
    assert sheet.shape == (rows * (GAP + HEIGHT), COLUMNS * (GAP + WIDTH), 3)
    assert len(np.unique(sheet.reshape(-1, 3), axis=0)) > 3
    with pytest.raises(ModelFileError, match="cannot be written"):
        draw_sheet(detector, truth, read_words(), tmp_path / "none" / "sheet.png")


def test_frames_that_cannot_be_judged_on(tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match=r"annotations\.json: not a readable COCO table"):
        read_truth(tmp_path)
    (tmp_path / "annotations.json").write_text('{"images": [], "annotations": []}')
    with pytest.raises(ModelFileError, match="not a readable COCO table"):
        read_truth(tmp_path)
    empty = {"images": [], "annotations": [], "categories": []}
    (tmp_path / "annotations.json").write_text(json.dumps(empty))
    with pytest.raises(ModelFileError, match="holds no frames"):
        read_truth(tmp_path)
