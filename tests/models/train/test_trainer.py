"""The trainer on drawn frames: targets, augmentation, and a loss that falls."""

import json
import os
import subprocess
import sys
import tomllib
import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

torch = pytest.importorskip("torch")

from drawn_shapes import SHAPES, draw_frames  # noqa: E402

from models.errors import ModelFileError  # noqa: E402
from models.train import average, data, finish, labelled, targets  # noqa: E402
from models.train.export import export, load_network  # noqa: E402
from models.train.losses import generalised_iou, room_loss  # noqa: E402
from models.train.names import PATH, load_names  # noqa: E402
from models.train.network import Network  # noqa: E402
from models.train.trainer import Recipe, Trainer  # noqa: E402


def embed(texts: Sequence[str]) -> np.ndarray:
    """Unit rows that depend on nothing but the text: no model is needed."""
    rows = [np.random.default_rng(zlib.crc32(t.encode())).standard_normal(384) for t in texts]
    return np.stack([r / np.linalg.norm(r) for r in rows]).astype(np.float32)


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("frames")
    draw_frames(out, 6, seed=3)
    return out


@pytest.fixture(scope="module")
def trainer(frames: Path) -> Trainer:
    torch.manual_seed(0)
    torch.set_num_threads(2)
    recipe = Recipe(warmup_steps=1, minutes=1e3)
    return Trainer(Network(frozen=0), load_names(embed), recipe)


def test_held_out_categories_are_ignored_and_unseen_names_are_not_trained(frames: Path) -> None:
    names = load_names(embed)
    whole = labelled.read_frames(frames, names.categories)
    gone = names.categories[int(whole[0].labels[0])]
    rest = [name for name in names.categories if name != gone]
    held = labelled.read_frames(frames, rest, [gone])
    for before, after in zip(whole, held, strict=True):
        lost = [names.categories[i] == gone for i in before.labels]
        assert after.ignore.tolist() == (before.ignore | np.array(lost, bool)).tolist()
        kept = [rest[i] for i, out in zip(after.labels, lost, strict=True) if not out]
        named = zip(before.labels, lost, strict=True)
        assert kept == [names.categories[i] for i, out in named if not out]
    table = tomllib.loads(PATH.read_text(encoding="utf-8"))
    trained = {name for body in table["categories"].values() for name in body["names"]}
    unseen = {name for body in table["categories"].values() for name in body.get("unseen", ())}
    assert len(unseen) > 50
    assert not trained & (unseen | {n for many in table["held_out"].values() for n in many})


def test_frames_with_a_scarce_category_are_shown_again() -> None:
    def frame(name: str, *labels: int, ignore: bool = False) -> data.Labelled:
        boxes = np.zeros((len(labels), 4), np.float32)
        kinds, hidden = np.array(labels, np.int64), np.full(len(labels), ignore)
        sure, boxed = np.ones(len(labels), np.float32), np.ones(3, np.float32)
        return labelled.Labelled(Path(name), boxes, kinds, hidden, sure, boxed, "")

    common = [frame(f"common{i}", 0) for i in range(396)]
    scarce = [frame(f"scarce{i}", 0, 1) for i in range(3)]
    frames = [*common, *scarce, frame("hidden", 2, ignore=True)]
    rng = np.random.default_rng(0)
    drawn = [[f.path.name for f in labelled.repeated(frames, rng)] for _ in range(50)]
    # Category 1 is in 3 of 400 frames where 12 would be common: twice each, on average exactly.
    counts = [sum(name.startswith("scarce") for name in names) for names in drawn]
    assert counts == [6] * 50
    assert all(names.count("hidden") == 1 for names in drawn)
    assert all(len(names) == 396 + 6 + 1 for names in drawn)


def test_a_lower_height_lowers_the_rates(trainer: Trainer) -> None:
    low = Trainer(trainer.network, trainer.names, replace(trainer.recipe, height=0.3))
    assert low.pace() == pytest.approx(
        0.3 * Trainer(trainer.network, trainer.names, trainer.recipe).pace()
    )


def test_a_few_steps_reduce_the_loss(frames: Path, trainer: Trainer) -> None:
    some = labelled.read_frames(frames, trainer.names.categories)[:2]
    batch = data.collate(some, trainer.names.rooms, np.random.default_rng(0), data.SMALL)
    costs = [float(trainer.learn(batch).total.detach()) for _ in range(6)]
    assert min(costs[3:]) < 0.8 * costs[0]


MEMBER = """
import sys
import torch
from models.train.team import together

def part(team):
    x, y = torch.zeros(3, requires_grad=True), torch.zeros(2, requires_grad=True)
    ((team.rank + 1) * x).sum().backward()
    team.average_gradients([x, y])
    shared = team.share([f"frame {i} of {team.rank}" for i in range(5)])
    mean = team.mean(10 / (2 - int(sys.argv[3]) - team.rank))
    said = [x.grad, y.grad, mean, shared]
    torch.save(said, f"{sys.argv[1]}/{team.rank}")

if __name__ == "__main__":
    together(int(sys.argv[2]), part)
"""


def members(folder: Path, count: int, fail: bool = False) -> subprocess.CompletedProcess[str]:
    """`count` processes that import what they do by name, as those of a training do."""
    script = folder / "member.py"
    script.write_text(MEMBER)
    command = [sys.executable, script, folder, str(count), str(int(fail))]
    return subprocess.run(command, capture_output=True, text=True, timeout=240)


def test_members_of_a_team_go_by_one_mean_gradient(tmp_path: Path) -> None:
    assert members(tmp_path, 2).returncode == 0
    for rank in (0, 1):
        x, y, mean, shared = torch.load(tmp_path / str(rank))
        assert x.tolist() == [1.5] * 3
        assert y.tolist() == [0.0] * 2  # it was in nobody's loss
        assert mean == 7.5
        assert shared == [f"frame {i} of 0" for i in (rank, rank + 2)]


def test_one_alone_is_its_own_team(tmp_path: Path) -> None:
    assert members(tmp_path, 1).returncode == 0
    x, y, mean, shared = torch.load(tmp_path / "0")
    assert (x.tolist(), y, mean, len(shared)) == ([1.0] * 3, None, 5.0, 5)


def test_a_failing_member_ends_the_team(tmp_path: Path) -> None:
    """The second fails while the first waits for it."""
    done = members(tmp_path, 2, fail=True)
    assert done.returncode == 1
    assert "ZeroDivisionError" in done.stderr


def test_a_checkpoint_resumes_and_exports(trainer: Trainer, tmp_path: Path) -> None:
    trainer.save(tmp_path / "c.pt")
    other = Trainer(Network(frozen=0), trainer.names, trainer.recipe)
    other.restore(tmp_path / "c.pt")
    assert other.step == trainer.step
    export(tmp_path / "c.pt", tmp_path / "d.onnx")
    assert (tmp_path / "d.onnx").stat().st_size < 12e6
    (tmp_path / "bad.pt").write_bytes(b"nothing")
    with pytest.raises(ModelFileError, match="not a checkpoint"):
        load_network(tmp_path / "bad.pt")


def test_the_mean_of_two_checkpoints(trainer: Trainer, tmp_path: Path) -> None:
    one, two = Network(frozen=0), Network(frozen=0)
    with torch.no_grad():
        one.bias.fill_(1.0)
        two.bias.fill_(2.0)
    for name, network in (("a.pt", one), ("b.pt", two)):
        torch.save({"average": network.state_dict()}, tmp_path / name)
    command = [*map(str, (tmp_path / "a.pt", tmp_path / "b.pt")), "--out", str(tmp_path / "c.pt")]
    assert CliRunner().invoke(average.main, [*command, "--share", "0.75"]).exit_code == 0
    mixed, _ = load_network(tmp_path / "c.pt")
    assert float(mixed.bias.detach()) == 1.75


def test_features_of_frames_are_stored(frames: Path, trainer: Trainer) -> None:
    names = trainer.names
    shown = labelled.read_frames(frames, names.categories) * 2
    features = finish.collect(trainer.average.eval(), shown, names, 1, 0, print)
    assert len(features.summary) == len(features.room) == finish.BATCH
    drawn = [names.categories[i] for i in np.flatnonzero((features.present == 1).any(0))]
    assert set(drawn) <= set(SHAPES)
    assert len(drawn) > 1
    assert len(features.regions) == len(features.label) == len(features.weight)


def test_features_are_kept_until_the_checkpoint_changes(tmp_path: Path) -> None:
    made = []

    def make() -> finish.Features:
        made.append(torch.full((1,), float(len(made))))
        return finish.Features(*[made[-1]] * 7)

    checkpoint = tmp_path / finish.CHECKPOINT
    checkpoint.write_bytes(b"one")
    first, again = (finish._kept(tmp_path, 1, 0, make) for _ in range(2))
    assert len(made) == 1
    assert float(first.room) == float(again.room) == 0.0
    assert float(finish._kept(tmp_path, 2, 0, make).room) == 1.0  # more passes
    os.utime(checkpoint, ns=(1, 1))
    assert float(finish._kept(tmp_path, 2, 0, make).room) == 2.0


def test_the_word_heads_learn_from_stored_features(trainer: Trainer) -> None:
    torch.manual_seed(0)
    names, network = trainer.names, trainer.average.eval()
    room, label = torch.randint(0, 2, (32,)), torch.randint(-1, 5, (64,))
    width = network.room[0].in_features
    summary = torch.randn(32, width) * 3 + 5
    summary[:, 0] += 8 * room
    present = torch.zeros(32, len(names.categories))
    present[:, 3], present[:, 4] = room.float(), torch.nan
    regions, boxed = torch.randn(64, 96), torch.ones(64, len(names.categories))
    features = finish.Features(regions, label, torch.rand(64), boxed, summary, room, present)
    done = finish.finish(network, features, names, 0, print, room_steps=60, word_steps=2)
    rows = names.draw_rooms(np.random.default_rng(0))
    before, after = (float(room_loss(n, summary, room, rows).detach()) for n in (network, done))
    assert after < 0.5 * before
    seen = done.embed_scene(summary) @ names.draw_views(np.random.default_rng(0)).T
    assert float((seen[room == 1, 3].mean() - seen[room == 0, 3].mean()).detach()) > 0.1


def test_augmented_boxes_stay_on_their_objects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(data, "_photograph", lambda image, rng: image)
    image = np.full((480, 640, 3), 255, np.uint8)
    image[150:300, 230:460] = 0
    boxes = np.array([[230, 150, 460, 300]], np.float32)
    sure = np.ones(1, np.float32)
    frame = labelled.Labelled(
        tmp_path, boxes, np.array([0]), np.array([False]), sure, np.ones(1, np.float32), ""
    )
    off = []
    for seed in range(40):
        out, moved = data.augment(image, frame, np.random.default_rng(seed))
        box = moved.boxes[0]
        dark = 1 - out[..., 0] / 255.0
        middle = ((box[:2] + box[2:]) / 2).astype(int)
        # The middle of what is dark along a line; what fills the rest of a frame that was made
        # smaller is grey, but far from the object.
        for line, low, high in (
            (dark[middle[1]], box[0], box[2]),
            (dark[:, middle[0]], box[1], box[3]),
        ):
            first = int(low) - 3
            around = line[max(0, first) : int(high) + 4]
            assert around.sum() == pytest.approx(high - low, abs=0.8), seed
            if first > 0 and high + 3 < len(line):
                centre = (np.arange(len(around)) + 0.5 + first) @ around / around.sum()
                off.append(float(centre - (low + high) / 2))
    assert len(off) > 30
    assert max(map(abs, off)) < 0.4
    assert abs(np.mean(off)) < 0.05


def test_a_square_picture_keeps_its_proportions(tmp_path: Path) -> None:
    box, one = np.array([[64, 64, 192, 192]], np.float32), np.ones(1, np.float32)
    frame = labelled.Labelled(tmp_path, box, np.array([0]), np.array([False]), one, one, "")
    image, stretched = np.zeros((256, 256, 3), np.uint8), []
    for seed in range(20):
        _, moved = data.augment(image, frame, np.random.default_rng(seed), (416, 320))
        if len(moved.boxes) and not moved.ignore[0]:
            x0, y0, x1, y1 = moved.boxes[0]
            if x0 > 0 and y0 > 0 and x1 < 416 and y1 < 320:  # not cut
                stretched.append((x1 - x0) / (y1 - y0))
    assert len(stretched) > 5
    assert stretched == pytest.approx([data.STRETCH] * len(stretched), abs=1e-3)


def test_unfinished_annotations_are_left_out(frames: Path, tmp_path: Path) -> None:
    (tmp_path / "annotations.json").write_text('{"images": [')
    with pytest.raises(ModelFileError, match="no annotated frames"):
        labelled.read_frames(tmp_path, ())


def test_shards_of_a_running_rendering_are_read(frames: Path, tmp_path: Path) -> None:
    whole = labelled.read_frames(frames, SHAPES)
    (tmp_path / "images").symlink_to(frames / "images")
    (tmp_path / "shards").mkdir()
    row = {"category": "toilet", "bbox": [1, 2, 30, 40], "area": 900, "ignore": True}
    shard = [{"file_name": whole[0].path.name, "room": "bathroom", "objects": [row]}]
    (tmp_path / "shards" / "train-000001.json").write_text(json.dumps(shard))
    (found,) = labelled.read_frames(tmp_path, SHAPES)
    assert found.boxes.tolist() == [[1, 2, 31, 42]]
    assert found.ignore.tolist() == [True]
    assert SHAPES[found.labels[0]] == "toilet"
    with pytest.raises(ModelFileError, match=r"category 'toilet' has no names in names\.toml"):
        labelled.read_frames(tmp_path, ("bed",))


def test_every_object_has_an_answer_and_ignored_ones_have_none() -> None:
    grid = targets.make_grid(320, 416)
    truth = torch.tensor([[10.0, 10, 16, 16], [50, 50, 350, 300], [200, 20, 260, 80]])
    ignore = torch.tensor([False, False, True])
    boxes = torch.cat((grid.centre - 30, grid.centre + 30), 1)
    found = targets.assign(grid, boxes, torch.zeros(len(boxes)), truth, ignore)
    assert set(found.owner.unique().tolist()) == {-1, 0, 1}
    inside = (grid.centre > truth[2, :2]).all(1) & (grid.centre < truth[2, 2:]).all(1)
    assert not found.counted[inside & (found.owner < 0)].any()
    assert (found.quality[found.owner >= 0] > 0).all()


def test_generalised_iou() -> None:
    a = torch.tensor([[0.0, 0, 10, 10], [0, 0, 10, 10]])
    b = torch.tensor([[0.0, 0, 10, 10], [20, 0, 30, 10]])
    assert generalised_iou(a, b).tolist() == pytest.approx([1.0, -1 / 3], abs=1e-4)
