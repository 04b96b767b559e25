"""Several detectors as one: whose turn it is, what each gives, what is remembered."""

import copy
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from baseline_graphs import grounding_network

from models.checksum import sha256
from models.detection.detections import RawDetections
from models.detection.detector import OpenDetector, open_detector
from models.detection.domain import DomainSetting
from models.detection.ensemble import DetectorEnsemble, open_detectors
from models.detection.fusion import FusionWeights
from models.errors import ModelFileError
from models.store import manifest
from models.words.text_encoder import TextEncoder

BOX = (8.0, 8.0, 40.0, 40.0)
CLASSES = (("sofa",), ("bed",))
HOME = FusionWeights(home={"drawn": "renderings", "photo": "photographs"})
FRAME = np.zeros((64, 96, 3), np.uint8)


class Sees:
    """A fixed list that sees one thing everywhere, and counts how often it is asked."""

    def __init__(self, label: int, score: float, unseen: tuple[str, ...] = ()) -> None:
        self.asked = 0
        one = np.array([BOX], np.float32), np.array([score], np.float32)
        none = np.zeros(0, np.float32)
        labels = np.array([label], np.int32)
        self.found = RawDetections(*one, labels, np.zeros((1, 0), np.float32), none, none)
        self.capabilities: dict[str, Any] = {
            "contract": "yolo v8", "open_vocabulary": False, "rooms": False, "embeddings": False,
            "classes": ["couch"], "matched": {"sofa": {"couch": 1.0}}, "unseen": list(unseen),
        }  # fmt: skip

    def set_vocabulary(self, classes: object, rooms: object) -> None:
        pass

    def detect(self, rgb: np.ndarray) -> RawDetections:
        self.asked += 1
        return self.found


@pytest.mark.parametrize(("domain", "asked"), [("photographs", [5, 10]), ("renderings", [10, 1])])
def test_the_others_look_at_every_second_frame_if_they_add_a_word(domain, asked: list[int]) -> None:
    drawn, photo = Sees(0, 0.6), Sees(0, 0.8, unseen=("bed",))
    both = DetectorEnsemble({"drawn": drawn, "photo": photo}, domain, 2, HOME)
    both.set_vocabulary(CLASSES, ())
    for _ in range(10):
        assert both.detect(FRAME).labels.tolist() == [0]
    assert [drawn.asked, photo.asked] == asked


def test_alone_it_looks_at_every_frame() -> None:
    drawn = Sees(0, 0.6)
    one = DetectorEnsemble({"drawn": drawn}, "photographs", 3, HOME)
    one.set_vocabulary(CLASSES, ())
    for _ in range(4):
        one.detect(FRAME)
    assert drawn.asked == 4
    with pytest.raises(ModelFileError, match=r"models\.detectors: is empty"):
        DetectorEnsemble({})


def test_what_can_be_seen_is_what_any_of_them_sees() -> None:
    both = DetectorEnsemble({"a": Sees(0, 0.5, ("bed", "sofa")), "b": Sees(0, 0.5, ("bed",))})
    both.set_vocabulary(CLASSES, ())
    said = both.capabilities
    assert said["unseen"] == ["bed"]
    assert said["matched"] == {"sofa": {"couch": 1.0}}
    assert said["classes"] == ["couch"]
    assert not said["open_vocabulary"]
    assert said["domain"]["is"] == "photographs"
    assert said["detectors"].keys() == {"a", "b"}


def test_images_are_remembered_as_long_as_asked() -> None:
    sees = Sees(0, 0.5)
    one = DetectorEnsemble({"a": sees})
    one.set_vocabulary(CLASSES, ())
    one.remember(2)
    frames = [np.full((8, 8, 3), k, np.uint8) for k in range(3)]
    for k in (0, 1, 0, 1, 2, 1):
        one.detect(frames[k])
    assert sees.asked == 3
    one.detect(frames[0])  # pushed out by the third
    assert sees.asked == 4
    one.set_vocabulary((("lamp",), ("bed",)), ())  # of other words nothing is known
    one.detect(frames[0])
    assert sees.asked == 5


def test_another_goal_is_asked_of_those_alone_that_look_for_one(
    tmp_path: Path, encoder: TextEncoder
) -> None:
    sees = Sees(0, 0.5)
    caption = grounding_network(tmp_path / "g.onnx", [(0.5, 0.5, 0.2, 0.2)] * 2, ("sofa", "bed"))
    looks = open_detector(caption, "auto", encoder)
    both = DetectorEnsemble({"list": sees, "caption": looks}, weights=FusionWeights())
    both.set_vocabulary(CLASSES, ())
    both.remember(1)
    white, found = np.full((64, 96, 3), 255, np.uint8), []
    for goal in (0, 1, 0):
        both.look_for(goal)
        found.append(sorted(both.detect(white).labels.tolist()))
    assert found == [[0, 0], [0, 1], [0, 0]]  # the caption's apart from the list's
    assert sees.asked == 1


def test_a_path_has_the_weights_of_the_model_that_it_is(
    tmp_path: Path, constant_graph, encoder: TextEncoder
) -> None:
    copy = tmp_path / "mine.onnx"
    shutil.copy(manifest.locate("nanodet-g"), copy)
    other = constant_graph({"out": np.zeros((1, 5, 126), np.float32)}, (64, 96), {"names": "['a']"})
    found = open_detectors([str(copy), str(other)], encoder)
    assert list(found) == ["nanodet-g", str(other)]


def our_graph(constant_graph, encoder: TextEncoder, **more: np.ndarray) -> Path:
    """Our contract: a sofa in BOX, another region without a name, and a scene like "kitchen"."""
    rows = encoder.embed(["sofa", "gravel", "kitchen"])
    row = np.zeros(rows.shape[1] + 1)
    row[:-1], row[-1] = 8 * rows[2], -2.0  # a kitchen is a photograph
    outputs = {
        "boxes": np.array([[BOX, (50, 8, 80, 40)]], np.float32),
        "objectness": np.array([[0.9, 0.1]], np.float32),
        "embeddings": rows[None, :2],
        "scene": rows[None, 2],
    }
    metadata = {
        "format": "rf-nav-detector/1", "value.scale": "20", "value.bias": "-10",
        "value.room_scale": "10", "photographs": str(row.tolist()),
    }  # fmt: skip
    path: Path = constant_graph(outputs | more, (64, 96), metadata)
    return path


@pytest.fixture
def ours(constant_graph, encoder: TextEncoder) -> OpenDetector:
    found = open_detector(our_graph(constant_graph, encoder), "rfnav", encoder)
    assert isinstance(found, OpenDetector)
    return found


def test_which_file_tells_features_is_known_by_its_sum(
    constant_graph, encoder: TextEncoder, ours: OpenDetector
) -> None:
    parts = np.arange(24, dtype=np.float32).reshape(1, 2, 3, 4)
    path = our_graph(constant_graph, encoder, features=parts)
    tells = open_detector(path, "rfnav", encoder)
    both = DetectorEnsemble({"list": Sees(1, 0.7), "tells": tells}, weights=HOME)
    both.set_vocabulary(CLASSES, ())
    loaded = sha256(path)
    path.write_bytes(b"another model")  # is not what runs
    assert both.features_of == (loaded,)
    assert (both.detect(FRAME).features == parts[0]).all()
    assert DetectorEnsemble({"list": Sees(1, 0.7), "ours": ours}).features_of == ()


def test_where_one_speaks_that_tells_no_features_another_is_asked_for_them(
    constant_graph, encoder: TextEncoder, ours: OpenDetector
) -> None:
    parts = np.arange(24, dtype=np.float32).reshape(1, 2, 3, 4)
    tells = open_detector(our_graph(constant_graph, encoder, features=parts), "rfnav", encoder)
    home = FusionWeights(home={"drawn": "renderings", "photo": "photographs"})
    both = DetectorEnsemble({"drawn": tells, "photo": ours}, "photographs", 2, home)
    both.set_vocabulary(CLASSES, ("kitchen",))
    assert both.detect(FRAME).features.size  # the first frame is looked at by all
    assert not both.detect(FRAME).features.size
    both.features_from = tells.sha256
    seen = both.detect(FRAME)
    assert (seen.features == parts[0]).all()
    assert seen.rooms.size


def test_one_that_has_looked_anyway_is_not_asked_for_its_features_again(
    constant_graph, encoder: TextEncoder, ours: OpenDetector, monkeypatch: pytest.MonkeyPatch
) -> None:
    parts = np.arange(24, dtype=np.float32).reshape(1, 2, 3, 4)
    tells = open_detector(our_graph(constant_graph, encoder, features=parts), "rfnav", encoder)
    assert isinstance(tells, OpenDetector)
    looks, look = [], tells.look
    monkeypatch.setattr(tells, "look", lambda rgb: (looks.append(1), look(rgb))[1])
    both = DetectorEnsemble({"first": ours, "tells": tells}, "photographs", weights=HOME)
    both.set_vocabulary(CLASSES, ())
    assert not both.detect(FRAME).features.size  # of who speaks, where nobody wants them
    both.features_from = tells.sha256
    assert (both.detect(FRAME).features == parts[0]).all()
    assert len(looks) == 2


def test_features_are_of_the_file_that_is_wanted_and_of_no_other(
    constant_graph, encoder: TextEncoder
) -> None:
    parts = np.arange(24, dtype=np.float32).reshape(1, 2, 3, 4)
    each = [
        open_detector(our_graph(constant_graph, encoder, features=n * parts), "rfnav", encoder)
        for n in (1, 2)
    ]
    both = DetectorEnsemble(dict(zip(("drawn", "photo"), each, strict=True)), weights=HOME)
    both.set_vocabulary(CLASSES, ("kitchen",))
    both.remember(1)
    assert (both.detect(FRAME).features == parts[0]).all()
    for n, wanted in ((2, each[1]), (1, each[0])):
        both.features_from = wanted.sha256
        assert (both.detect(FRAME).features == n * parts[0]).all()
    both.features_from = "another's"
    assert not both.detect(FRAME).features.size


def test_ours_tells_rooms_looks_and_the_domain(ours: OpenDetector) -> None:
    other = Sees(1, 0.7)
    other.found = other.found._replace(boxes_px=np.array([(52, 8, 80, 40)], np.float32))
    both = DetectorEnsemble({"list": other, "ours": ours}, weights=HOME)
    both.set_vocabulary(CLASSES, ("bedroom", "kitchen"))
    seen = both.detect(FRAME)
    sofa = int(np.flatnonzero((seen.labels == 0) & (seen.scores > 0.5))[0])
    bed = int(np.flatnonzero(seen.labels == 1)[0])
    view = ours.look(FRAME)
    assert seen.embeddings[sofa] == pytest.approx(view.regions[0], abs=1e-5)
    # what the list saw looks as the region there does
    assert seen.embeddings[bed] == pytest.approx(view.regions[1], abs=1e-5)
    assert seen.rooms.argmax() == 1
    assert seen.scene == pytest.approx(view.scene)
    assert both.domain.told()["is"] == "photographs"
    assert both.domain.log_odds == pytest.approx(6.0, abs=0.2)


def test_a_direction_of_no_use_is_one_line(constant_graph, encoder: TextEncoder) -> None:
    outputs = {
        "boxes": np.zeros((1, 1, 4), np.float32), "objectness": np.zeros((1, 1), np.float32),
        "embeddings": np.zeros((1, 1, 384), np.float32), "scene": np.zeros((1, 384), np.float32),
    }  # fmt: skip
    metadata = {
        "format": "rf-nav-detector/1", "value.scale": "20", "value.bias": "-10",
        "value.room_scale": "10", "photographs": "[1, 2]",
    }  # fmt: skip
    path = constant_graph(outputs, (64, 96), metadata)
    with pytest.raises(ModelFileError, match="is no list of 385 numbers"):
        open_detector(path, "rfnav", encoder)


def test_outputs_go_by_their_order_whatever_their_names(
    constant_graph, encoder: TextEncoder
) -> None:
    row = np.full(385, 0.5)
    outputs = {
        "b": np.zeros((1, 1, 4), np.float32), "o": np.zeros((1, 1), np.float32),
        "e": np.zeros((1, 1, 384), np.float32), "s": np.zeros((1, 384), np.float32),
    }  # fmt: skip
    metadata = {
        "format": "rf-nav-detector/1", "value.scale": "20", "value.bias": "-10",
        "value.room_scale": "10", "photographs": str(row.tolist()),
    }  # fmt: skip
    found = open_detector(constant_graph(outputs, (64, 96), metadata), "rfnav", encoder)
    assert isinstance(found, OpenDetector)
    assert found.photograph_odds(found.look(FRAME).scene) == pytest.approx(0.5)
    del outputs["s"]
    path = constant_graph(outputs, (64, 96), metadata)
    with pytest.raises(ModelFileError, match="3 outputs; expected boxes, objectness, embeddings"):
        open_detector(path, "rfnav", encoder)


def test_what_is_small_is_looked_at_more_closely_while_others_rest() -> None:
    drawn, photo = Sees(0, 0.6), Sees(0, 0.8)
    both = DetectorEnsemble({"drawn": drawn, "photo": photo}, "renderings", 2, HOME)
    both.set_vocabulary(CLASSES, ())
    asked = []

    def window() -> tuple[int, int, int, int]:
        asked.append(1)
        return 8, 8, 90, 62

    for _ in range(4):
        both.detect(FRAME, window)
    assert (drawn.asked, photo.asked, len(asked)) == (4, 1, 0)
    both.closer = True
    found = [both.detect(FRAME, window) for _ in range(4)]
    assert (drawn.asked, photo.asked, len(asked)) == (10, 1, 2)
    assert [len(f.scores) for f in found] == [1, 2, 1, 2]  # BOX again, in the part
    assert found[1].boxes_px[1].tolist() == [16, 16, 48, 48]


def test_every_run_begins_alike(ours: OpenDetector) -> None:
    """Whose turn it is, and the domain, are of this run alone."""
    home = FusionWeights(home={"ours": "renderings", "list": "photographs"})
    other = Sees(1, 0.7, unseen=("sofa",))
    both = DetectorEnsemble({"list": other, "ours": ours}, "auto", 2, home)
    both.set_vocabulary(CLASSES, ())
    runs = []
    for _ in range(2):
        both.begin()
        assert both.domain.images == 0
        runs.append([len(both.detect(FRAME).scores) for _ in range(3)])
    assert runs[0] == runs[1]
    assert runs[0][0] > runs[0][1]  # ours rests at every second frame


@pytest.mark.parametrize(("unseen", "asked"), [((), 1), (("sofa",), 4)])
def test_without_a_budget_all_that_add_a_word_look_at_every_frame(unseen, asked: int) -> None:
    drawn, photo = Sees(0, 0.6, unseen=unseen), Sees(0, 0.8)
    both = DetectorEnsemble({"drawn": drawn, "photo": photo}, "renderings", weights=HOME)
    both.set_vocabulary(CLASSES, ())
    for _ in range(4):
        both.detect(FRAME)
    assert (drawn.asked, photo.asked) == (4, asked)


@pytest.mark.parametrize(
    ("domain", "looks"),
    [
        ("renderings", ["drawn list photo", "drawn", "drawn", "drawn"]),
        ("photographs", ["drawn list photo", "list", "list photo", "list"]),
        ("auto", ["drawn list photo", "list", "list photo", "list"]),  # a kitchen is a photograph
    ],
)
def test_of_two_of_our_own_the_one_of_this_domain_looks(
    domain: DomainSetting, looks: list[str], ours: OpenDetector, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = FusionWeights(
        home={"drawn": "renderings", "list": "photographs", "photo": "photographs"}
    )
    other, asked = Sees(1, 0.7, unseen=("sofa",)), list[str]()
    three = {"drawn": ours, "list": other, "photo": copy.copy(ours)}

    def noted(name: str, look: Callable[[np.ndarray], Any]) -> Callable[[np.ndarray], Any]:
        def looking(rgb: np.ndarray) -> Any:
            asked.append(name)
            return look(rgb)

        return looking

    for name in ("drawn", "photo"):
        monkeypatch.setattr(three[name], "look", noted(name, three[name].look))
    monkeypatch.setattr(other, "detect", noted("list", other.detect))
    one = DetectorEnsemble(three, domain, 2, home)
    one.set_vocabulary(CLASSES, ("kitchen",))
    turns = []
    for _ in looks:
        asked.clear()
        seen = one.detect(FRAME)
        turns.append(" ".join(sorted(asked)))
        assert bool(seen.rooms.size) == ("drawn" in asked or "photo" in asked)
    assert turns == looks


def test_where_nobody_rests_there_is_no_time_for_a_closer_look() -> None:
    home = FusionWeights(home={"a": "photographs", "b": "photographs"})
    seen = [Sees(0, 0.6), Sees(0, 0.8)]
    both = DetectorEnsemble(dict(zip("ab", seen, strict=True)), "photographs", 2, home)
    both.set_vocabulary(CLASSES, ())
    both.closer = True
    for _ in range(4):
        both.detect(FRAME, lambda: (8, 8, 90, 62))
    assert [s.asked for s in seen] == [4, 4]
