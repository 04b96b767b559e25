import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from looked import home_views

from hil_sim.commands.beyond import HOMES, PLAN_FILE, beyond_command, home_names
from hil_sim.expert_bench.bank import side_of
from hil_sim.expert_bench.views import write_views
from runtime.errors import RfNavError


def test_a_longer_list_of_homes_begins_with_the_shorter_one():
    names = home_names(20, 200_000, "train", replicas=True)
    assert names[:7] == home_names(7, 200_000, "train", replicas=True)
    assert len(set(names)) == 20
    replicas = [name for name in names if name.startswith("FloorPlan_Train")]
    assert len(replicas) == 4
    assert {side_of(name) for name in replicas} == {"fit"}


def test_homes_of_the_other_split_have_no_replicas():
    assert home_names(3, 300_000, "val", replicas=False) == [
        "val-300000", "val-300001", "val-300002",
    ]  # fmt: skip


def run(folder: Path, *options: str) -> Result:
    """Of homes that all are there already."""
    return CliRunner().invoke(beyond_command, ["--out", str(folder), *options])


@pytest.fixture
def made(tmp_path: Path) -> Path:
    (tmp_path / HOMES).mkdir()
    for seed in (7, 8, 9):
        write_views(tmp_path / HOMES / f"train-{seed}.npz", home_views())
    assert run(tmp_path, "--homes", "2", "--seed", "7").exit_code == 0
    return tmp_path


def test_a_folder_goes_on_with_more_homes(made: Path):
    assert json.loads((made / PLAN_FILE).read_text())["seed"] == 7
    more = run(made, "--homes", "3", "--seed", "7")
    assert more.output == f"3 homes in {made / HOMES}: 72 views in 72 frames\n"


def test_what_another_detector_sees_is_kept_beside(made: Path, monkeypatch: pytest.MonkeyPatch):
    asked = list[str]()

    def make_homes(names: list[str], todo: list[str], workers: int, make: object) -> None:
        for name in todo:
            asked.append(name)
            write_views(made / "clean" / HOMES / f"{name}.npz", home_views())

    monkeypatch.setattr("hil_sim.commands.beyond.make_homes", make_homes)
    told = run(made, "--homes", "2", "--seed", "7", "--also", "files/clean.onnx")
    assert asked == ["train-7", "train-8"]  # though they are there already
    homes = [f"2 homes in {folder / HOMES}" for folder in (made, made / "clean")]
    assert [line.partition(":")[0] for line in told.output.splitlines()] == homes
    assert json.loads((made / "clean" / PLAN_FILE).read_text())["seed"] == 7


@pytest.mark.parametrize("others", [("a/x.onnx", "b/x.onnx"), ("homes.onnx",), ("rfnav-det",)])
def test_two_models_that_would_be_kept_in_one_folder_are_refused(
    tmp_path: Path, others: tuple[str, ...]
):
    refused = run(tmp_path, *(part for other in others for part in ("--also", other)))
    assert refused.exit_code == 2
    assert "--also: two models of one name" in refused.output


@pytest.mark.parametrize(
    ("options", "changed"),
    [
        (("--seed", "8"), "seed"),
        (("--seed", "7", "--split", "val"), "split"),
        (("--seed", "7", "--replicas"), "replicas"),
        (("--seed", "8", "--replicas"), "replicas, seed"),
    ],
)
def test_a_folder_of_other_homes_is_refused(made: Path, options: tuple[str, ...], changed: str):
    refused = run(made, "--homes", "1", *options).exception
    assert isinstance(refused, RfNavError)
    told = f"{made / PLAN_FILE}: was made with other {changed}; use another folder"
    assert str(refused) == told


def test_a_broken_plan_is_refused(made: Path):
    for text in ("{", "[1]", "{}", '"seed"'):
        (made / PLAN_FILE).write_text(text)
        refused = run(made, "--homes", "1", "--seed", "7").exception
        assert isinstance(refused, RfNavError)
        assert "not a plan of homes" in str(refused)


def test_replicas_of_the_other_split_are_refused(tmp_path: Path):
    refused = run(tmp_path / "out", "--split", "val", "--replicas")
    assert refused.exit_code == 2
    assert refused.output.splitlines()[-1].startswith("Error: --replicas are of the split train")
    assert not (tmp_path / "out").exists()
