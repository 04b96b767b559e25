"""Two folders are equal but for wall times, or the first difference is named."""

import json
from pathlib import Path

import pytest

from hil_sim.evaluation.compare import main
from hil_sim.evaluation.results import FORMER_MODELS


def folder(
    path: Path, steps: int = 9, wall: float = 1.0, x: float = 0.5, rows: int = 2,
    settings: tuple[str, ...] = (),
) -> str:  # fmt: skip
    path.mkdir()
    told = {"suite": "val", "seed": 0, "settings": settings}
    (path / "run.json").write_text(json.dumps(told))
    lines = []
    for i in range(rows):
        wall_times = {"total": wall}
        row = {"method": "rfnav", "episode": f"e{i}", "steps": steps, "wall": wall_times}
        lines.append(json.dumps(row))
        track = path / "rfnav" / f"e{i}" / "track.jsonl"
        track.parent.mkdir(parents=True)
        track.write_text(json.dumps({"x": x}) + "\n")
    order = lines if wall == 1.0 else lines[::-1]
    (path / "episodes.jsonl").write_text("\n".join(order) + "\n")
    return str(path)


def test_only_wall_times_and_order_may_differ(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one, two = folder(tmp_path / "a"), folder(tmp_path / "b", wall=2.0)
    assert main([one, two]) == 0
    assert capsys.readouterr().out == "equal: 2 episodes\n"


def test_a_key_that_was_renamed_since_is_the_same_key(tmp_path: Path) -> None:
    one = folder(tmp_path / "a", settings=("experts.bar=1.3", "models.threads=1"))
    two = folder(tmp_path / "b", settings=("research.experts_bar=1.3", "models.threads=1"))
    other = folder(tmp_path / "c", settings=("research.experts_bar=1.4", "models.threads=1"))
    assert main([one, two]) == 0
    assert main([one, other]) == 1


def test_a_folder_from_before_the_manifest_changed_a_comment_has_the_same_models(
    tmp_path: Path,
) -> None:
    runs = {"a": "06f013d8935ca412", "b": FORMER_MODELS["06f013d8935ca412"], "c": "another"}
    for name, models in runs.items():
        folder(tmp_path / name)
        run = tmp_path / name / "run.json"
        run.write_text(json.dumps({**json.loads(run.read_text()), "models": models}))
    assert main([str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    assert main([str(tmp_path / "a"), str(tmp_path / "c")]) == 1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"steps": 10}, "different: rfnav e0: steps: 9 and 10\n"),
        ({"x": 0.6}, 'different: rfnav e0: track.jsonl:1: {"x": 0.5} and {"x": 0.6}\n'),
        ({"rows": 3}, "different: rfnav e2: not in "),
    ],
)
def test_the_first_difference_is_named(
    change: dict[str, float], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    one = folder(tmp_path / "a")
    two = folder(tmp_path / "b", **change)  # type: ignore[arg-type]
    assert main([one, two]) == 1
    assert capsys.readouterr().out.startswith(said)


def test_no_results_are_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path), str(tmp_path)]) == 2
    assert "run.json: no such file; name folders that" in capsys.readouterr().err
    assert main([]) == 2
