"""The files of a bank: what is written is read, equal homes are equal bytes, layouts stay whole."""

import gzip
import json
from dataclasses import replace
from pathlib import Path

import pytest
from asked import moment
from sighted import sight

from hil_sim.expert_bench.bank import (
    CLEAN,
    HOMES,
    BankHome,
    layout_of,
    load_bank,
    questions_of,
    read_home,
    side_of,
    write_home,
)
from hil_sim.expert_bench.make import home_names
from runtime.errors import RfNavError


def home(name: str = "train-100000", detector: str = "e") -> BankHome:
    return BankHome(name, (moment(name), moment(name, 20)), {"on the map": 2}, detector)


def write(folder: Path, *homes: BankHome) -> Path:
    (folder / HOMES).mkdir(exist_ok=True)
    for one in homes:
        write_home(folder / HOMES / f"{one.name}.jsonl.gz", one)
    return folder


def test_a_home_is_read_as_it_was_written(tmp_path: Path) -> None:
    path = write(tmp_path, home()) / HOMES / "train-100000.jsonl.gz"
    found = read_home(path)
    assert found == home()  # views are left out of comparing
    told = found.moments[0].briefs
    assert told[CLEAN].frontiers[0].view.tolist() == [0.5, -0.25]
    assert told["missing objects"].frontiers[0].view.tolist() == [0.5, -0.25]
    assert told[CLEAN].frontiers[1].view.size == 0


def test_what_a_keyframe_showed_is_written_once(tmp_path: Path) -> None:
    one = moment()
    near, far = one.briefs[CLEAN].frontiers
    shared = replace(one.briefs[CLEAN], frontiers=(near, replace(far, sight=sight(0.75, 4.0))))
    path = tmp_path / "a"
    told = replace(one, briefs={**one.briefs, CLEAN: shared})
    write_home(path, BankHome("a", (told, told), {}, "e"))
    lines = gzip.decompress(path.read_bytes()).splitlines()
    _, looks, *moments = [json.loads(line) for line in lines]
    assert list(looks) == ["0"]
    assert [[s["look"] for s in m["sights"]] for m in moments] == [["0", "0"]] * 2
    first, second = read_home(path).moments[1].briefs["missing objects"].frontiers
    assert first.sight is not None
    assert second.sight is not None
    assert (first.sight.features == sight(0.0).features).all()
    assert (first.sight.depth == sight(0.0).depth).all()
    assert (second.sight.column, second.sight.range_m) == (0.75, 4.0)
    other = replace(near, sight=sight(0.25, mark=1)), replace(far, sight=None)
    brief = replace(one.briefs[CLEAN], frontiers=other)
    write_home(path, BankHome("a", (told, replace(one, briefs={CLEAN: brief})), {}, "e"))
    first, second = read_home(path).moments[1].briefs[CLEAN].frontiers
    assert first.sight is not None
    assert first.sight.features[0, 0, 0] == 1.0
    assert second.sight is None


def test_equal_homes_are_equal_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_home(tmp_path / name, home())
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_question_knows_what_each_choice_costs() -> None:
    (question,) = questions_of(replace(home(), moments=(moment(),)))
    assert question.goal == "toilet"
    assert question.brief().goal == "toilet"
    assert question.regrets_m == {3: 5.0, 7: 0.0}
    assert [(f.id, f.goal_xy, f.distance_m) for f in question.frontiers()] == [
        (3, (1.0, 0.0), 1.0),
        (7, (0.0, 2.0), 2.0),
    ]


def test_only_frontiers_that_are_told_of_can_be_chosen() -> None:
    one = moment()
    (near, far), told = one.briefs[CLEAN].frontiers, one.briefs[CLEAN]
    third = replace(one, ids=(3, 5, 7), goal_xy=((1.0, 0.0), (5.0, 5.0), (0.0, 2.0)))
    asked = replace(third, costs_m={"toilet": (9.0, 1.0, 4.0)})
    (question,) = questions_of(replace(home(), moments=(asked,)))
    assert question.regrets_m == {3: 5.0, 7: 0.0}
    assert [f.goal_xy for f in question.frontiers()] == [(1.0, 0.0), (0.0, 2.0)]
    alone = replace(asked, briefs={CLEAN: replace(told, frontiers=(near,))})
    alike = replace(asked, costs_m={"toilet": (9.0, 1.0, 8.6)})
    assert far.id == 7
    assert not list(questions_of(replace(home(), moments=(alone, alike))))


def test_no_layout_is_on_both_sides() -> None:
    names = home_names(200, 0)
    assert len(set(names)) == 200
    sides: dict[str, set[str]] = {}
    for name in names:
        sides.setdefault(layout_of(name), set()).add(side_of(name))
    assert all(len(side) == 1 for side in sides.values())
    assert sum(side == {"fit"} for side in sides.values()) == pytest.approx(len(sides) / 2, abs=3)
    assert layout_of("FloorPlan_Train3_5") == layout_of("FloorPlan_Train3_1")
    assert layout_of("FloorPlan_Train3_5") != layout_of("FloorPlan_Train11_5")


def test_a_longer_bank_begins_with_the_shorter_one() -> None:
    assert home_names(90, 0)[:30] == home_names(30, 0)
    assert not set(home_names(30, 0)) & {n for n in home_names(30, 1) if n.startswith("train-")}
    assert all("Train" in n or n.startswith("train-") for n in home_names(100, 0))


def test_a_side_is_loaded_alone(tmp_path: Path) -> None:
    bank = write(tmp_path, home(), home("train-100001"))
    assert {q.moment.home for q in load_bank(bank, "fit").questions} == {"train-100000"}
    assert {q.moment.home for q in load_bank(bank, "test").questions} == {"train-100001"}
    both = load_bank(bank)
    assert (len(both.questions), both.homes, both.left_out["on the map"]) == (4, 2, 4)


def test_what_cannot_be_used_is_named(tmp_path: Path) -> None:
    with pytest.raises(RfNavError, match="no questions of side fit"):
        load_bank(tmp_path, "fit")
    bank = write(tmp_path, home(), home("train-100001", detector="others"))
    with pytest.raises(RfNavError, match="different detectors"):
        load_bank(bank)
    path = bank / HOMES / "train-100000.jsonl.gz"
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(RfNavError, match=r"train-100000\.jsonl\.gz: not a home's questions"):
        load_bank(bank, "fit")
