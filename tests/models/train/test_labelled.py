"""Folders of frames: what is boxed throughout, and how much of an epoch each is."""

import json
from pathlib import Path

import click
import numpy as np
import pytest
from drawn_shapes import SHAPES, draw_frames

from models.errors import ModelFileError
from models.train.labelled import UNLEARNED, Portion, PortionParam, read_epoch, read_frames

CATEGORIES = (*SHAPES, "sofa")


def say_labelled(folder: Path, *names: str) -> None:
    """As if only these were boxed throughout."""
    path = folder / "annotations.json"
    table = json.loads(path.read_text())
    path.write_text(json.dumps({**table, "info": {"labelled": names}}))


def test_a_table_says_what_is_boxed_throughout(tmp_path: Path) -> None:
    draw_frames(tmp_path, 3)
    assert all((frame.boxed == 1).all() for frame in read_frames(tmp_path, CATEGORIES))
    say_labelled(tmp_path, "bed", "plant", "unheard of")
    for frame in read_frames(tmp_path, CATEGORIES):
        assert frame.boxed.tolist() == [1, 0, 1, 0, 0]
        assert frame.surety.tolist() == [1.0] * len(frame.labels)


def test_what_is_no_category_is_ignored_only_where_others_may_be(tmp_path: Path) -> None:
    draw_frames(tmp_path, 3)
    with pytest.raises(ModelFileError, match=r"has no names in names\.toml"):
        read_frames(tmp_path, ("bed", "toilet"))
    say_labelled(tmp_path, *SHAPES)
    frames = read_frames(tmp_path, ("bed", "toilet"))
    labels = np.concatenate([frame.labels for frame in frames])
    ignored = np.concatenate([frame.ignore for frame in frames])
    assert set(labels.tolist()) >= {UNLEARNED}
    assert ignored.tolist() == (labels == UNLEARNED).tolist()


def test_an_epoch_is_shared(tmp_path: Path) -> None:
    whole, few, many = tmp_path / "whole", tmp_path / "few", tmp_path / "many"
    for folder, count in ((whole, 30), (few, 2), (many, 40)):
        folder.mkdir()
        draw_frames(folder, count)
    sources = [Portion(few, 0.2), Portion(whole), Portion(many, 0.3)]
    shown = read_epoch(sources, CATEGORIES, (), np.random.default_rng(0))
    counts = {f: [s.path for s in shown if f in s.path.parents] for f in (whole, few, many)}
    assert len(counts[whole]) == 30  # nothing is scarce there
    assert (len(counts[few]), len(counts[many])) == (12, 18)
    assert {counts[few].count(path) for path in set(counts[few])} == {6}
    assert len(set(counts[many])) == 18


@pytest.mark.parametrize("shares", [(0.5,), (None, 0.5, 0.5)])
def test_shares_that_leave_nothing(tmp_path: Path, shares: tuple[float | None, ...]) -> None:
    draw_frames(tmp_path, 2)
    with pytest.raises(ModelFileError, match="must be less than 1"):
        read_epoch(
            [Portion(tmp_path, share) for share in shares], CATEGORIES, (), np.random.default_rng(0)
        )


def test_a_source_on_the_command_line(tmp_path: Path) -> None:
    read = PortionParam()
    assert read.convert(f"{tmp_path}", None, None) == Portion(tmp_path)
    assert read.convert(f"{tmp_path}=0.25", None, None) == Portion(tmp_path, 0.25)
    for bad in ("2", "0", "half"):
        with pytest.raises(click.BadParameter, match="between 0 and 1"):
            read.convert(f"{tmp_path}={bad}", None, None)
    with pytest.raises(click.BadParameter, match="no such folder"):
        read.convert(f"{tmp_path}/none", None, None)
