"""What was taught is one file, whose reader says what torch says; the projector can be taught."""

from pathlib import Path

import numpy as np
import pytest
from drawn_homes import draw_homes

torch = pytest.importorskip("torch")

from models.errors import ModelFileError  # noqa: E402
from models.language.scene_layout import SceneLayout  # noqa: E402
from models.store import manifest  # noqa: E402
from models.train import beyond_language  # noqa: E402
from models.train.beyond_data import Moments, read_homes  # noqa: E402
from models.train.beyond_export import export, main, whole  # noqa: E402
from models.train.beyond_head import Lesson, pictures, plain_head  # noqa: E402
from models.train.beyond_language import ProjectorTrainer, examine_projector  # noqa: E402
from models.train.beyond_network import evidence  # noqa: E402
from models.train.beyond_speech import bridge, read_speech  # noqa: E402
from models.train.beyond_words import load_words  # noqa: E402
from models.words.text_encoder import TextEncoder  # noqa: E402

ENTRIES = {
    "detector": "d", "language": "l", "text": "{}",
    "templates": '{"beyond": " a", "view": " b", "room": " c"}',
}  # fmt: skip


def test_the_example_names_what_is_required() -> None:
    required = [p.opts[0] for p in main.params if p.required]
    assert required == ["--run", "--data", "--dev"]
    assert all(f"{name} " in f"{main.epilog} " for name in required)


@pytest.mark.slow
def test_a_projector_learns_and_is_exported(
    tmp_path: Path, encoder: TextEncoder, monkeypatch: pytest.MonkeyPatch
) -> None:
    torch.set_num_threads(1)
    torch.manual_seed(0)
    monkeypatch.setattr(beyond_language, "EXAMINED", 12)
    draw_homes(tmp_path, 2, 1)
    homes = read_homes(tmp_path)
    lesson = Lesson(homes, homes, load_words(homes.categories, homes.room_names, encoder.embed))
    path = manifest.fetch("smollm2-135m")
    speech = read_speech(path, lesson.words)
    assert not speech.taught[lesson.words.called.index(("guitar",))]
    way = bridge(path, speech, lesson.words, encoder.embed, 60)
    head = plain_head(homes).eval()
    trainer = ProjectorTrainer(lesson, speech, way, head, 12, seed=1)
    rng = np.random.default_rng(0)
    rows = next(Moments.of(homes).draw(2, rng))
    said = [trainer.learn(rng, rows) for _ in range(7)]
    assert set(said[-1]) >= {"beyond", "onward", "spoken", "view"}
    assert said[3]["room"] < said[0]["room"]
    trainer.save(tmp_path / "run.pt")
    other = ProjectorTrainer(lesson, speech, way, head, 12, seed=2)
    other.restore(tmp_path / "run.pt")
    assert other.step == 7
    scores = examine_projector(other.average, other.blank, lesson, speech)
    assert np.isfinite(scores.onward)

    with pytest.raises(ModelFileError, match=r"head\.pt: missing"):
        whole(tmp_path, homes, homes, lesson.words)
    torch.nn.init.normal_(head.vector.weight)
    torch.nn.init.normal_(head.sure.weight)
    torch.save(head.state_dict(), tmp_path / "head.pt")
    torch.save(other.average.state_dict(), tmp_path / "projector.pt")
    network = whole(tmp_path, homes, homes, lesson.words)
    sights = pictures(homes, homes.frame[:9], homes.way()[:9])
    export(network, tmp_path / "out.onnx", ENTRIES, sights)
    told = SceneLayout(tmp_path / "out.onnx")
    assert told.template == " a"
    assert told.blank.shape == (8, 576)
    looked = told.look(*(x.numpy() for x in sights))
    assert looked.tokens.shape == (9, 8, 576)
    names = lesson.words.canonical()
    nats = np.stack([told.evidence(looked.beyond, row) for row in names.numpy()], 1)
    with torch.no_grad():
        best = homes.frame[homes.best], homes.way()[homes.best]
        every = evidence(head(*pictures(homes, *best)).beyond, names - names.mean(0))
        own = evidence(head(*sights).beyond, names - names.mean(0))
    alone = whole(tmp_path, homes, homes, lesson.words, silent=True)
    export(alone, tmp_path / "silent.onnx", {**ENTRIES, "language": ""}, sights)
    silent = SceneLayout(tmp_path / "silent.onnx").look(*(x.numpy() for x in sights))
    np.testing.assert_allclose(silent.beyond, looked.beyond, atol=1e-5)
    np.testing.assert_allclose(nats, network.gain * (own - every.mean(0)).numpy(), atol=0.1)
