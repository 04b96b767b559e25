"""The composition of models: which are loaded for which configuration, and what cannot be."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from layout_graph import write_layout
from mmproj import write_mmproj

from models.checksum import sha256
from models.detection.second_look import SecondLook
from models.onnx_session import open_session
from models.store import manifest
from models.words.row_file import RowFile
from models.words.text_encoder import TextEncoder
from runtime.clock import Deadline, SystemClock
from runtime.config import Config, load
from runtime.core.mapping import keyframes
from runtime.core.types import (
    Brief,
    FrontierBrief,
    Intrinsics,
    Missing,
    Mount,
    NearbyObject,
    Observation,
    Pose,
    Vote,
)
from runtime.core.voting.likelihood_experts import LikelihoodQuestion
from runtime.errors import ConfigError, ModelError
from runtime.perception.loaded_models import LoadedModels

pytestmark = pytest.mark.slow  # the real models are loaded

CLOUD = (
    "cloud.enabled=true",
    "cloud.base_url='http://127.0.0.1:9/v1'",
    "cloud.model='big'",
    "cloud.price_in_usd=0.0",
    "cloud.price_out_usd=0.0",
)


EMBEDDED: dict[str, np.ndarray] = {}
embed_alone = TextEncoder._embedded


@pytest.fixture(autouse=True)
def _embedded_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """All these minds have one text encoder: the row of a text is made once for all of them."""

    def embedded(self: TextEncoder, text: str) -> np.ndarray:
        if text not in EMBEDDED:
            EMBEDDED[text] = embed_alone(self, text)
        return EMBEDDED[text]

    monkeypatch.setattr(TextEncoder, "_embedded", embedded)


def jpeg(bgr: tuple[int, int, int]) -> bytes:
    return cv2.imencode(".jpg", np.full((60, 80, 3), bgr, np.uint8))[1].tobytes()


SINK, BED = NearbyObject("sink", 0.9, 0.5), NearbyObject("bed", 0.9, 0.5)
BRIEF = Brief(
    "toilet",
    0,
    (
        FrontierBrief(4, 1.0, (SINK,), (("bathroom", 1.0),), image=jpeg((255, 0, 0))),
        FrontierBrief(9, 2.0, (BED,), (("bedroom", 1.0),), image=jpeg((0, 0, 255))),
    ),
)


def configured(tmp_path: Path, *settings: str) -> Config:
    return load(None, (f"research.cloud_spending_file='{tmp_path}/spending.sqlite'", *settings))


def never() -> Deadline:
    return Deadline.never(SystemClock())


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("models.vision='/nowhere/see.gguf'", "models.vision_projector: must name the mmproj GGUF"),
        ("models.vision='smollm2-135m'", "models.vision: smollm2-135m is a model for language"),
        ("models.language='/nowhere/x.gguf'", "/nowhere/x.gguf: no such model file"),
    ],
)
def test_what_cannot_be_loaded_is_said(setting: str, message: str, tmp_path: Path) -> None:
    config = configured(tmp_path, setting, "keyframes.image_width_px=160")
    with pytest.raises((ConfigError, ModelError)) as error:
        LoadedModels(config, SystemClock())
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)


def test_a_model_that_sees_needs_images_to_be_kept(tmp_path: Path) -> None:
    for settings in (("models.vision='x.gguf'",), (*CLOUD, "cloud.privacy='full'")):
        with pytest.raises(ConfigError, match=r"^keyframes\.image_width_px: is 0"):
            configured(tmp_path, *settings)
    configured(tmp_path, *CLOUD, "cloud.privacy='full'", "research.cloud_images=false")


def test_a_goal_cannot_send_the_key_elsewhere(tmp_path: Path) -> None:
    """Settings come with a goal's request, over the bus; the cloud is the operator's business."""
    clock = SystemClock()
    with LoadedModels(configured(tmp_path, *CLOUD, "panel.experts=[]"), clock) as models:
        other = configured(tmp_path, *CLOUD, "cloud.base_url='http://127.0.0.1:10/v1'")
        with pytest.raises(ConfigError, match="cloud: cannot change while the runtime runs"):
            models.accept("toilet", other)


def test_the_vocabulary_is_embedded_before_a_goal_waits_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    embedded: list[str] = []
    monkeypatch.setattr(RowFile, "load", lambda self: {})  # of the start before nothing is kept
    monkeypatch.setattr(RowFile, "keep", lambda self, rows: None)
    alone = TextEncoder._embedded
    monkeypatch.setattr(
        TextEncoder, "_embedded", lambda self, text: embedded.append(text) or alone(self, text)
    )
    with LoadedModels(configured(tmp_path, "panel.experts=[]"), SystemClock()) as models:
        before = len(embedded)
        models.accept("toilet", configured(tmp_path, "panel.experts=[]"))
        assert before > 100
        assert len(embedded) == before


def test_what_was_seen_before_is_compared_with_the_goals_words(tmp_path: Path) -> None:
    """A region that looks just like a word of the detector's is that; one that looks like the
    opposite of all words is nothing."""
    config = configured(tmp_path, "panel.experts=[]")
    with LoadedModels(config, SystemClock()) as models:
        goal, _ = models.accept("couch", config)
        names = [words[0] for words in goal.classes]
        kept = models._encoder.embed(["bed", "couch"])
        nothing = -kept.sum(axis=0, keepdims=True) / np.linalg.norm(kept.sum(axis=0))
        likeness = models.likeness(np.concatenate([kept, nothing]))
    assert likeness.shape == (3, len(names))
    assert ((likeness >= 0) & (likeness <= 1)).all()
    assert [names[i] for i in likeness[:2].argmax(axis=1)] == ["bed", goal.name]
    assert likeness[1, names.index(goal.name)] > 0.9
    assert likeness[2].max() < 0.1


@pytest.mark.slow
@pytest.mark.parametrize("kept", [True, False])
def test_scores_outlive_their_goal_unless_told(tmp_path: Path, kept: bool) -> None:
    settings = f"research.keep_scores={str(kept).lower()}", f"models.score_file='{tmp_path}/s'"
    config = configured(tmp_path, "models.threads=1", *settings)
    question = LikelihoodQuestion("A sink is found in the", "kitchen")
    with LoadedModels(config, SystemClock()) as models:
        models.accept("toilet", config)
        seating = models._open_seating()
        assert seating.by_likelihood is not None
        scorer = seating.by_likelihood.scorer
        first = scorer.answer([question], never())
        models.accept("bed", config)
        assert ((scorer._first, question) in scorer._cache) == kept
        assert scorer.answer([question], never()) == first


MANIFEST = """
[tiny-vlm]
task = "vision"
licence = "Apache-2.0"
style = "reason"
handler = "llava-1.5"
"""
FILE = """
[[tiny-vlm.files]]
name = "{path.name}"
bytes = {size}
sha256 = "{sha256}"
sources = []
"""


@pytest.mark.slow
def test_a_model_that_sees_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files, handler and style are those of its entry in the manifest."""
    cache = manifest.cache_dir()
    mine = tmp_path / "cache" / "rf-nav" / "models"
    (mine / "tiny-vlm").mkdir(parents=True)
    for known in cache.iterdir():
        (mine / known.name).symlink_to(known)
    parts = [mine / "tiny-vlm" / name for name in ("text.gguf", "mmproj.gguf")]
    parts[0].symlink_to(manifest.fetch("smollm2-135m"))
    write_mmproj(parts[1])
    entry = MANIFEST + "".join(
        FILE.format(path=p, size=p.stat().st_size, sha256=sha256(p)) for p in parts
    )
    (tmp_path / "data" / "rf-nav").mkdir(parents=True)
    (tmp_path / "data" / "rf-nav" / "models.toml").write_text(entry)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    config = configured(
        tmp_path, "models.vision='tiny-vlm'", "keyframes.image_width_px=160", "models.threads=1"
    )
    with LoadedModels(config, SystemClock()) as models:
        outcome = models.seated(config)["sle"](BRIEF, never())
        assert models._open_seating().looks_in_words
    if isinstance(outcome, Vote):
        assert outcome.rung == "local"
    else:
        assert outcome.cause.startswith("abstains")


@pytest.mark.slow
def test_large_models_reason_and_see(tmp_path: Path) -> None:
    """With a small one in their place: it keeps to the form, whatever it says."""
    text = manifest.fetch("smollm2-135m")
    config = configured(
        tmp_path,
        "models.language_style='reason'",
        "research.word_evidence=language",
        f"models.language='{text}'",
        f"models.vision='{text}'",
        f"models.vision_projector='{write_mmproj(tmp_path / 'mmproj.gguf')}'",
        "models.vision_handler='llava-1.5'",
        "models.threads=1",
        "keyframes.image_width_px=160",
    )
    with LoadedModels(config, SystemClock()) as models:
        models.accept("toilet", config)
        table = models.seated(config)
        scene = table["sle"](BRIEF, never())
        words = table["o2f"](BRIEF, never())
    for outcome in (scene, words):
        if isinstance(outcome, Vote):
            assert outcome.rung == "local"
            assert set(outcome.frontiers) <= {4, 9}
        else:
            assert isinstance(outcome, Missing)
            assert outcome.cause.startswith(("no preference", "abstains"))


def test_a_goal_is_understood_by_all_that_the_word_list_has(tmp_path: Path) -> None:
    names = tmp_path / "words.toml"
    names.write_text(
        'objects = [["zig"], ["zag"], ["chair"]]\nrooms = ["hall"]\n'
        'also.zig = ["frobnicator"]\nkinds.zig = ["zag"]\n'
    )
    config = configured(tmp_path, "panel.experts=[]", f"models.vocabulary='{names}'")
    with LoadedModels(config, SystemClock()) as models:
        goal, _ = models.accept("the frobnicator", config)
        assert goal.how.startswith("the frobnicator: another word for zig")
        assert goal.classes == (("zig", "zag"), ("zag",), ("chair",))
        assert (
            "a kind of chair" in models.accept("chaise longue", config)[0].how
        )  # by the dictionary


@pytest.mark.parametrize(
    ("goal", "settings", "said"),
    [
        ("umbrella", (), "looked at twice, for: umbrella"),
        ("umbrella", ("research.second_looks=0",), ""),
        ("umbrella", ("research.second_look=''",), ""),
        ("umbrella", ("research.detector_source='topic'",), ""),
        ("toilet", (), ""),
        ("thermostat", (), "it will hardly be recognised"),
    ],
)
def test_what_the_detector_has_no_word_for_is_looked_at_twice(
    goal: str, settings: tuple[str, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks = []
    monkeypatch.setattr(
        SecondLook,
        "classify",
        lambda self, rgb, boxes: looks.append(len(boxes)) or np.full((len(boxes), 1000), 1e-3),
    )
    seen = "models.domain='renderings'"  # else ours rests every other frame
    config = configured(tmp_path, "panel.experts=[]", seen, *settings)
    with LoadedModels(config, SystemClock()) as models:
        how = models.accept(goal, config)[0].how
        assert said in how
        assert ("twice" in how) is ("twice" in said)
        rng = np.random.default_rng(0)
        for _ in range(2):
            models.detect(rng.integers(0, 255, (480, 640, 3), np.uint8))
        assert models.health()["domain"]["images"] == 2
        models.accept(goal, config)
        assert models.health()["domain"]["images"] == 0  # each search is a run of its own
    assert looks == ([5, 5] if "twice" in said else [])


def test_a_second_look_is_of_its_goal_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From a strange goal to a known one and back, with the same image, which is remembered; a goal
    that is refused changes nothing."""
    looks = []
    monkeypatch.setattr(
        SecondLook,
        "classify",
        lambda self, rgb, boxes: looks.append(len(boxes)) or np.full((len(boxes), 1000), 1e-3),
    )
    nobody = "models.language='/nowhere/x.gguf'"
    plain = ("panel.experts=[]", "research.detector_memo_frames=8", nobody)
    listed = configured(tmp_path, *plain, "research.detector_labels=['umbrella']")
    config = configured(tmp_path, *plain)
    image = np.random.default_rng(0).integers(0, 255, (480, 640, 3), np.uint8)
    with LoadedModels(config, SystemClock()) as models:
        for goal, told, count in (
            ("umbrella", config, 1),
            ("toilet", config, 1),
            ("umbrella", config, 1),  # remembered
            ("umbrella", listed, 1),  # the same classes, but a known one: not looked at twice
        ):
            models.accept(goal, told)
            models.detect(image)
            assert len(looks) == count
        models.accept("umbrella", config)
        with pytest.raises(ModelError):
            models.accept(
                "key", configured(tmp_path, *plain, f"research.detector_labels=['{'y' * 101}']")
            )
        with pytest.raises(ModelError, match="no such model file"):
            models.accept("toilet", configured(tmp_path, nobody))
        image[0, 0] = 0
        models.detect(image)
        assert len(looks) == 2  # the umbrella's second look goes on


def test_a_scene_layout_that_is_not_there_is_said_once_and_sle_goes_on_without(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sets = "research.scene_layout='head'", "research.scene_layout_file='/nowhere/layout.onnx'"
    config = configured(tmp_path, *sets, "panel.experts=['sle']")
    with LoadedModels(config, SystemClock()) as models:
        like = models._encoder.embed(["a room with a toilet"])[0]
        near, far = BRIEF.frontiers
        told = replace(BRIEF, frontiers=(replace(near, view=like), replace(far, view=-like)))
        outcome = models.seated(config)["sle"](told, never())
        assert isinstance(outcome, Vote)
        assert (outcome.frontiers, outcome.rung) == ((4,), "embedding")
        models.accept("toilet", config)
        assert models._detector._all.features_from == ""  # nobody would look at them
        (error,) = models.health()["errors"]
    assert str(error).startswith("/nowhere/layout.onnx: no such model file")
    assert capsys.readouterr().err.count(str(error)) == 1


def test_a_detector_without_a_scene_layout_expert_is_no_fault(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = "panel.experts=['sle']", "models.detectors=['nanodet-g']", "models.threads=1"
    config = configured(tmp_path, *settings)
    with LoadedModels(config, SystemClock()) as models:
        for goal in ("toilet", "bed"):
            models.accept(goal, config)
        assert models.health()["errors"] == []
    said = capsys.readouterr().err
    assert said.count("made for a detector that models.detectors does not have") == 1


@pytest.mark.parametrize("rung", ["head", "language"])
def test_sle_is_shown_what_the_detector_saw(tmp_path: Path, rung: str) -> None:
    """From an image to a vote, with the detector and the language model that there are."""
    detector, language = (manifest.fetch(name) for name in ("rfnav-det", "smollm2-135m"))
    parts = open_session(detector, 1).get_outputs()[4].shape[1:]
    path = tmp_path / "layout.onnx"
    write_layout(path, tuple(parts), sha256(detector), sha256(language))
    shown = f"research.scene_layout='{rung}'", f"research.scene_layout_file='{path}'"
    sets = *shown, "panel.experts=['sle']", "research.experts_bar=0.9"
    config = configured(tmp_path, *sets, "models.detectors=['rfnav-det']", "models.threads=1")
    rng = np.random.default_rng(0)
    k = Intrinsics(320.0, 320.0, 320.0, 240.0, 640, 480)
    with LoadedModels(config, SystemClock()) as models:
        path.unlink()  # it was opened with the others
        models.accept("toilet", config)
        assert models._detector._all.features_from == sha256(detector)
        seen = []
        for n, frontier in enumerate(BRIEF.frontiers):
            rgb = cv2.resize(rng.integers(0, 255, (6, 8, 3), np.uint8), (640, 480))
            obs = Observation(n, rgb, np.full((480, 640), 2.0, np.float32), Pose(0, 0, 0), k)
            frame = keyframes.take(obs, models.detect(rgb), Mount(), 0)
            sight = keyframes.sight_toward(frame, np.array([[2.0, 0.3]]))
            assert sight is not None
            seen.append(replace(frontier, sight=sight))
        vote = models.seated(config)["sle"](replace(BRIEF, frontiers=tuple(seen)), never())
        assert models.health()["errors"] == []
        models.accept(
            "toilet", replace(config, experts=replace(config.experts, scene_layout="embedding"))
        )
        assert models._detector._all.features_from == ""
    assert isinstance(vote, Vote)
    assert vote.rung == rung
