"""Taking in other people's detectors, from files and URLs: each contract, what is said, what is
refused."""

import http.server
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from places import SHARED

from models.checksum import sha256
from models.detection.detector import open_detector
from models.detection.imported import Offer, take_in
from models.detection.trial import Limits
from models.errors import ModelFileError
from models.store import manifest
from models.words.class_maps import coco_names
from models.words.text_encoder import TextEncoder
from runtime.errors import ModelError
from runtime.perception.models_command import models_command

pytestmark = pytest.mark.slow  # whole networks are taken in

SIZE = (64, 96)
CELLS = 8 * 12 + 4 * 6 + 2 * 3
LIMITS = Limits(seconds=120)
REAL = SHARED / "models" / "yolox_nano.onnx"


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
    out[0, :, 0] = (48, 32, 40, 20, 0.9, 0.0, 0.0)
    return constant_graph({"out": out}, SIZE, {"names": names} if names else {})


def import_(path: Path, name: str, classes: Path | str = "", **more: str) -> Path:
    return take_in(Offer(str(path), name, str(classes), **more), LIMITS).path


def test_a_fixed_list_says_what_it_is_matched_with(
    home: Path, constant_graph, encoder: TextEncoder
) -> None:
    said = run("import", str(yolo(constant_graph)), "--as", "mine", "--limit-s", "120")
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
    with pytest.raises(ModelFileError, match=r"prompted\.onnx: it takes embedded texts; give them"):
        import_(path, "world")
    with pytest.raises(ModelFileError, match=r"tokenizer\.json: no such file"):
        import_(path, "world", texts=str(path))
    import_(path, "world", texts=str(home / "rows.npz"))
    (home / "rows.npz").unlink()
    path.unlink()
    found = manifest.fetch("world")
    assert sorted(p.name for p in found.iterdir()) == ["model.onnx", "texts.npz"]
    detector = open_detector(found, "auto", encoder)
    detector.set_vocabulary((("bed",), ("sofa",)), ())
    assert detector.detect(np.zeros((64, 96, 3), np.uint8)).labels.tolist() == [1]


def test_one_of_ours_is_taken_in(home: Path) -> None:
    theirs = Path(manifest.PACKAGE) / "weights" / "rfnav-det.onnx"
    found = take_in(Offer(str(theirs), "copy"), LIMITS)
    assert found.trial.capabilities["contract"] == "rfnav"
    assert found.trial.capabilities["open_vocabulary"]
    (found.path / "model.onnx").write_bytes(b"damaged")
    with pytest.raises(ModelFileError, match="damaged: sha256"):
        manifest.verify("copy")
    assert manifest.fetch("copy").read_bytes() == theirs.read_bytes()  # from where it was


def test_a_name_imported_again_is_replaced(home: Path, constant_graph, encoder) -> None:
    import_(yolo(constant_graph), "mine")
    names = home / "names.txt"
    names.write_text("bed\nsofa\nlamp\n")
    import_(yolo(constant_graph, ""), "mine", names)
    names.unlink()  # its content is in the entry
    (manifest.cache_dir() / "mine" / "classes.txt").unlink()
    found = open_detector(manifest.fetch("mine"), "auto", encoder)
    assert found.capabilities["classes"] == ["bed", "sofa", "lamp"]


def test_what_was_told_is_kept(home: Path, constant_graph, encoder: TextEncoder) -> None:
    own = home / "map.toml"
    own.write_text('[classes]\nsettle = "sofa"\nghost = ""\nwc = "toilet"\n')
    found = open_detector(import_(yolo(constant_graph, ""), "mine", own), "auto", encoder)
    assert found.capabilities["classes"] == ["settle", "ghost", "wc"]
    found.set_vocabulary((("sofa",), ("toilet",)), ())
    assert found.capabilities["matched"] == {"sofa": {"settle": 1.0}, "toilet": {"wc": 1.0}}
    out = {"out": np.zeros((1, CELLS, 6), np.float32)}
    one = constant_graph(out, SIZE, {"names": "['couch']"})
    with pytest.raises(ModelFileError, match=r"graph\.onnx: outputs .* X or end-to-end; say which"):
        import_(one, "odd")
    path = import_(one, "odd", layout="end-to-end", normalise="imagenet")
    assert open_detector(path, "auto", encoder).capabilities["contract"] == "end-to-end"
    told = '[classes]\nsettle = "sofer"\n'
    own.write_text(told)
    with pytest.raises(ModelFileError, match=r"map\.toml: classes\.settle = 'sofer': no class of"):
        import_(one, "odd", own)


@pytest.mark.parametrize("name", ["", "a b", "../up", "Große", "x" * 41, "rfnav-det", "d-fine-n"])
def test_bad_names(name: str, home: Path, constant_graph) -> None:
    with pytest.raises(ModelFileError, match=r"not a name|is a model of the project"):
        import_(yolo(constant_graph), name)
    assert not manifest.user_manifest().exists()


def test_what_is_refused_is_not_kept(home: Path, constant_graph) -> None:
    def refused(path: Path, said: str, classes: Path | str = "") -> None:
        with pytest.raises(ModelFileError, match=said) as caught:
            import_(path, "bad", classes)
        assert ".partial" not in str(caught.value)
        assert "\n" not in str(caught.value)
        assert "bad" not in manifest.load_manifest()
        assert [p.name for p in manifest.cache_dir().iterdir()] == ["minilm"]

    refused(home / "none.onnx", r"none\.onnx: no such file")
    (home / "text.onnx").write_text("not a model")
    refused(home / "text.onnx", r"text\.onnx: not a usable ONNX file")
    refused(yolo(constant_graph, ""), "its 3 classes have no names")
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
        refused(yolo(constant_graph, ""), rf"names\.txt: .*{said}", home / "names.txt")


def test_a_text_model_is_no_detector(encoder: TextEncoder) -> None:
    with pytest.raises(ModelFileError, match=r"no detector of a known contract \(inputs input_ids"):
        open_detector(manifest.fetch("minilm") / "model.onnx", "auto", encoder)


@pytest.mark.skipif(not REAL.exists(), reason="needs a copy of YOLOX-Nano")
def test_a_real_fixed_list_is_taken_in(home: Path) -> None:
    said = run("import", str(REAL), "--as", "yolox", "--classes", "coco", "--limit-s", "120")
    assert "contract: yolo X" in said
    assert "a fixed list of 80, COCO's" in said
    for pair in ("bed <- bed (1.00)", "sofa <- couch (1.00)", "television <- tv (1.00)"):
        assert pair in said
    assert "toilet" in run("try", "yolox", "--limit-s", "120").split("bathroom.jpg")[1]


@pytest.fixture
def server(tmp_path: Path) -> Iterator[str]:
    """What lies in the folder `far`, over HTTP; `half.onnx` ends early."""
    far = tmp_path / "far"
    far.mkdir()

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            content = (far / Path(self.path).name.replace("half", "net")).read_bytes()
            self.send_response(200)
            self.send_header("Content-Length", str(len(content)))
            self.end_headers()
            self.wfile.write(content[: len(content) // 2 if "half" in self.path else None])

        def log_message(self, *_: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as served:
        thread = threading.Thread(target=served.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{served.server_port}"
        served.shutdown()
        thread.join()


def test_what_a_url_gives_first_is_what_its_name_stands_for(
    home: Path, server: str, constant_graph, encoder: TextEncoder
) -> None:
    far, url = home / "far" / "net.onnx", f"{server}/net.onnx"
    yolo(constant_graph).rename(far)
    digest, content = sha256(far), far.read_bytes()
    licence = ("--licence", "AGPL-3.0", "--accept-licence", "agpl-3.0", "--limit-s", "120")
    said = run("add", url, *licence)
    assert f"pinned to sha256 {digest}" in said
    assert "contract: yolo v8" in said
    entry = manifest.load_manifest()["net"]
    assert (entry.licence, entry.files[0].sha256) == ("AGPL-3.0", digest)
    # the same is fetched again when it is gone, with the licence; another is not
    (manifest.cache_dir() / "net" / "model.onnx").unlink()
    with pytest.raises(ModelFileError, match=r"is AGPL-3\.0.*`rfnav models pull net --acc"):
        manifest.fetch("net")
    far.write_bytes(content[:-1] + b"x")
    with pytest.raises(ModelFileError, match="refused: sha256 is"):
        manifest.fetch("net", accepted="AGPL-3.0")
    with pytest.raises(ModelFileError, match=r"refused: .* that of net is pinned to .* another"):
        take_in(Offer(url, "net", licence="MIT"), LIMITS)
    assert not (manifest.cache_dir() / "net" / "model.onnx").exists()
    far.write_bytes(content)
    run("pull", "net", "--accept-licence", "AGPL-3.0")
    assert run("verify", "net") == "net: ok\n"


def test_what_a_url_gives_in_part_is_not_taken_for_whole(
    home: Path, server: str, constant_graph
) -> None:
    yolo(constant_graph).rename(home / "far" / "net.onnx")
    for url, said in (
        (f"{server}/half.onnx", r"half\.onnx: ended after \d+ of \d+ bytes"),
        ("ftp://nowhere/net.onnx", "cannot be read; known are https, http, file URLs"),
        (f"{server.rpartition(':')[0]}:1/net.onnx", "cannot be read"),
    ):
        with pytest.raises(ModelFileError, match=said) as told:
            take_in(Offer(url, "net", licence="MIT"), LIMITS)
        assert "\n" not in str(told.value)
        assert "net" not in manifest.load_manifest()
        assert [p.name for p in manifest.cache_dir().iterdir()] == ["minilm"]


def test_a_licence_that_asks_for_something_is_accepted_by_its_name(home: Path) -> None:
    for more, told in (
        ((), r"net: its licence is unknown.*--accept-licence unknown`"),
        (("--licence", "AGPL-3.0", "--accept-licence", "MIT"), r"its licence is AGPL-3\.0"),
        (("--licence", "MIT AND AGPL-3.0"), r"its licence is MIT AND AGPL-3\.0"),
    ):
        with pytest.raises(ModelError, match=told):
            run("add", "file:///nowhere/net.onnx", *more)
    for licence in ("Apache-2.0 AND MIT", "GPL-3.0 OR MIT"):  # these are asked for it
        with pytest.raises(ModelError, match=r"nowhere/net\.onnx: cannot be read"):
            run("add", "file:///nowhere/net.onnx", "--licence", licence)


def test_d_fine_is_known_with_its_names(
    home: Path, constant_graph, encoder: TextEncoder, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What its entry says of a file is right for outputs of its shape."""
    entry = manifest.entry("d-fine-n")
    assert entry.files[0].sources[0].url.startswith("https://huggingface.co/AnnotateIt/dfine-nano")
    logits, boxes = np.full((1, 300, 80), -8.0), np.full((1, 300, 4), 0.5)
    logits[0, 0, coco_names().index("toilet")] = 2
    path = constant_graph({"logits": logits, "pred_boxes": boxes}, SIZE)
    path.rename(path.parent / "model.onnx")
    (path.parent / "contract.toml").write_text(entry.files[1].sources[0].text)
    assert sha256(path.parent / "contract.toml") == entry.files[1].sha256
    detector = open_detector(path.parent, "auto", encoder)
    assert detector.capabilities["contract"] == "detr"
    detector.set_vocabulary((("toilet",),), ())
    assert detector.detect(np.zeros((64, 96, 3), np.uint8)).labels.tolist() == [0]
