"""Importing other people's detectors: each contract, what is said, what is refused."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from places import SHARED

from models.detection.detector import open_detector
from models.detection.imported import import_detector
from models.errors import ModelFileError
from models.store import manifest
from models.words.text_encoder import TextEncoder
from runtime.perception.models_command import models_command

pytestmark = pytest.mark.slow  # whole networks are taken in

SIZE = (64, 96)
CELLS = 8 * 12 + 4 * 6 + 2 * 3
REAL = SHARED / "models" / "yolox_nano.onnx"
COCO = (
    "person bicycle car motorcycle airplane bus train truck boat traffic_light fire_hydrant "
    "stop_sign parking_meter bench bird cat dog horse sheep cow elephant bear zebra giraffe "
    "backpack umbrella handbag tie suitcase frisbee skis snowboard sports_ball kite baseball_bat "
    "baseball_glove skateboard surfboard tennis_racket bottle wine_glass cup fork knife spoon bowl "
    "banana apple sandwich orange broccoli carrot hot_dog pizza donut cake chair couch "
    "potted_plant bed dining_table toilet tv laptop mouse remote keyboard cell_phone microwave "
    "oven toaster sink refrigerator book clock vase scissors teddy_bear hair_drier toothbrush"
).replace("_", "-")


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's data are elsewhere; the text encoder stays where it was fetched."""
    cache = manifest.cache_dir()
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    mine = manifest.cache_dir()
    mine.mkdir(parents=True)
    (mine / "minilm").symlink_to(cache / "minilm")
    return tmp_path


def run(*arguments: str) -> str:
    done = CliRunner().invoke(models_command, list(arguments), catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


def yolo(constant_graph, names: str = "{0: 'couch', 1: 'giraffe', 2: 'toilet'}") -> Path:
    out = np.zeros((1, 7, CELLS), np.float32)
    out[0, :, 0] = (48, 32, 40, 20, 0.9, 0.0, 0.1)
    return constant_graph({"out": out}, SIZE, {"names": names} if names else {})


def test_a_fixed_list_says_what_it_is_matched_with(
    home: Path, constant_graph, encoder: TextEncoder
) -> None:
    said = run("import", str(yolo(constant_graph)), "--as", "mine")
    assert "contract: yolo v8" in said
    assert "a fixed list of 3, matched to the goal by similarity" in said
    assert "sofa <- couch (1.00), toilet <- toilet (1.00)" in said
    assert "cannot be seen: bed, chair" in said
    assert 'models.detectors = ["mine"]' in said
    assert "mine" in run("list")
    assert run("verify", "mine") == "mine: ok\n"
    detector = open_detector(manifest.fetch("mine"), "auto", encoder)
    detector.set_vocabulary((("sofa", "couch"),), ())
    assert detector.detect(np.zeros((64, 96, 3), np.uint8)).labels.tolist() == [0]


def test_a_prompted_one_takes_its_texts_along(
    home: Path, prompted_graph, encoder: TextEncoder
) -> None:
    boxes = np.array([[10, 10, 60, 60]], np.float32)
    path = prompted_graph(boxes, np.array([[0, 0.8]], np.float32), SIZE)
    np.savez(home / "rows.npz", bed=np.array([1.0, 0]), sofa=np.array([0, 1.0]))
    said = run("import", str(path), "--as", "world", "--texts", str(home / "rows.npz"))
    assert "contract: prompted" in said
    assert "cannot be seen: chair" in said
    (home / "rows.npz").unlink()
    path.unlink()
    found = manifest.fetch("world")
    assert sorted(p.name for p in found.iterdir()) == ["model.onnx", "texts.npz"]
    detector = open_detector(found, "auto", encoder)
    detector.set_vocabulary((("bed",), ("sofa",)), ())
    assert detector.detect(np.zeros((64, 96, 3), np.uint8)).labels.tolist() == [1]


def test_one_of_ours_is_taken_in(home: Path, encoder: TextEncoder) -> None:
    theirs = Path(manifest.PACKAGE) / "weights" / "rfnav-det.onnx"
    found = import_detector(theirs, "copy", encoder, None, None)
    assert found.capabilities["contract"] == "rfnav"
    assert found.capabilities["open_vocabulary"]
    (found.path / "model.onnx").write_bytes(b"damaged")
    with pytest.raises(ModelFileError, match="damaged: sha256"):
        manifest.verify("copy")
    assert manifest.fetch("copy").read_bytes() == theirs.read_bytes()  # from where it was


def test_a_name_imported_again_is_replaced(home: Path, constant_graph, encoder) -> None:
    import_detector(yolo(constant_graph), "mine", encoder, None, None)
    names = home / "names.txt"
    names.write_text("bed\nsofa\nlamp\n")
    import_detector(yolo(constant_graph, ""), 'o.k-"'[:4], encoder, names, None)
    import_detector(yolo(constant_graph, ""), "mine", encoder, names, None)
    assert {"mine", "o.k-"} <= set(manifest.load_manifest())
    found = open_detector(manifest.fetch("mine"), "auto", encoder)
    assert found.capabilities["classes"] == ["bed", "sofa", "lamp"]


@pytest.mark.parametrize("name", ["", "a b", "../up", "Große", "x" * 41, "rfnav-det"])
def test_bad_names(name: str, home: Path, constant_graph, encoder: TextEncoder) -> None:
    with pytest.raises(ModelFileError, match=r"not a name|is a model of the project"):
        import_detector(yolo(constant_graph), name, encoder, None, None)
    assert not manifest.user_manifest().exists()


def test_what_is_refused_is_not_kept(home: Path, constant_graph, encoder: TextEncoder) -> None:
    def refused(path: Path, said: str, classes: Path | None = None) -> None:
        with pytest.raises(ModelFileError, match=said) as caught:
            import_detector(path, "bad", encoder, classes, None)
        assert ".partial" not in str(caught.value)
        assert "bad" not in manifest.load_manifest()
        assert [p.name for p in manifest.cache_dir().iterdir()] == ["minilm"]

    refused(home / "none.onnx", r"none\.onnx: no such file")
    (home / "text.onnx").write_text("not a model")
    refused(home / "text.onnx", r"text\.onnx: not a usable ONNX file")
    refused(yolo(constant_graph, ""), "its 3 classes have no names")
    odd = constant_graph({"out": np.zeros((1, 7, CELLS))}, SIZE, {"format": "rf-nav-detector/9"})
    refused(odd, "format 'rf-nav-detector/9'")
    loud = np.zeros((1, CELLS, 8), np.float32)
    loud[0, 0] = (0, 0, 3, 3, 9.0, 1.0, 0, 0)
    names = {"names": "['couch', 'bed', 'tv']"}
    refused(constant_graph({"out": loud}, SIZE, names), "gives scores above 1")
    for text, said in (
        ("", "the class list is empty"),
        ("a\n" * 2001, "2001 names; at most 2000"),
        ("a\nb\n" + "x" * 10_000, "10000 characters; at most 100"),
    ):
        (home / "names.txt").write_text(text)
        refused(yolo(constant_graph, ""), said, home / "names.txt")


def test_a_text_model_is_no_detector(encoder: TextEncoder) -> None:
    with pytest.raises(ModelFileError, match=r"no detector of a known contract \(inputs input_ids"):
        open_detector(manifest.fetch("minilm") / "model.onnx", "auto", encoder)


@pytest.mark.skipif(not REAL.exists(), reason="needs a copy of YOLOX-Nano")
def test_a_real_fixed_list_is_taken_in(home: Path) -> None:
    names = home / "coco.txt"
    names.write_text("\n".join(n.replace("-", " ") for n in COCO.split()))
    said = run("import", str(REAL), "--as", "yolox", "--classes", str(names))
    assert "contract: yolo X" in said
    assert "a fixed list of 80" in said
    for pair in ("bed <- bed (1.00)", "sofa <- couch (1.00)", "television <- tv (1.00)"):
        assert pair in said
