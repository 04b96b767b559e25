"""Everything about the scene-layout expert at once, with experts and views whose answers are
known."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from asked import moment
from looked import DETECTOR, home_views, write_homes
from manual_clock import ManualClock

from hil_sim.expert_bench import scene_report
from hil_sim.expert_bench.bank import HOMES, Bank, BankHome, write_home
from hil_sim.expert_bench.scene import measure
from hil_sim.expert_bench.scene_bank import Insight
from hil_sim.expert_bench.scene_plan import KINDS, ScenePlan
from hil_sim.expert_bench.scene_report import SceneFigures
from hil_sim.expert_bench.scene_speed import SceneSeconds
from hil_sim.expert_bench.statistics import Resampling
from hil_sim.expert_bench.view_questions import Floats, SightRows
from hil_sim.expert_bench.views import write_views
from hil_sim.expert_bench.voting import Votes
from runtime.clock import Deadline
from runtime.config import Config
from runtime.core.types import Brief, Missing, Vote
from runtime.errors import RfNavError
from runtime.experts.panel import EXPERTS


class Sighted:
    """It sees what the first feature tells of beds."""

    def evidence(self, about: object, sights: SightRows, names: Sequence[str]) -> Floats:
        known = np.array([name in ("bed", "bedroom") for name in names], float)
        return sights.features[:, 0, 0, 0].astype(float)[:, None] * known


class Electors:
    """R2F votes for the last frontier, O2F for the first. SLE, by the kind that is asked for, votes
    with O2F as "head", with R2F else: it decides."""

    def __init__(self, settings: Sequence[str]) -> None:
        self.settings, self.warmed = settings, 0

    def warm(self, bank: Bank) -> None:
        self.warmed += 1

    def asked(self, config: Config, questions: Sequence[object]) -> Votes:
        def vote(expert: str, brief: Brief) -> Vote | Missing:
            ids = [f.id for f in brief.frontiers]
            rung = config.experts.scene_layout if expert == "sle" else "local"
            chosen = ids[0] if expert == "o2f" or rung == "head" else ids[-1]
            return Vote(expert, (chosen,), tuple((i, i + 1.0) for i in ids), "given", rung)

        table = {e: (lambda brief, by, e=e: vote(e, brief)) for e in EXPERTS}
        return Votes(table, questions, Deadline.never(ManualClock()))

    def check(self) -> None: ...


@pytest.fixture
def plan(tmp_path: Path) -> ScenePlan:
    bank = tmp_path / "bank"
    (bank / HOMES).mkdir(parents=True)
    for name in ("train-100000", "train-100001"):
        home = BankHome(name, (moment(name), moment(name, 20)), {}, "e")
        write_home(bank / HOMES / f"{name}.jsonl.gz", home)
    dev, train = (write_homes(tmp_path / n, homes=3, rows=64) for n in ("dev", "train"))
    return ScenePlan(dev, train, 0, 1, bank=bank, sides=("fit", "test"))


def measured(plan: ScenePlan) -> tuple[SceneFigures, list[Electors]]:
    opened = list[Electors]()

    def open_voters(settings: Sequence[str]) -> AbstractContextManager[Electors]:
        opened.append(Electors(settings))
        return nullcontext(opened[-1])

    kinds: Mapping[str, Sighted] = {kind: Sighted() for kind in plan.kinds}
    found = measure(plan, kinds, lambda names: np.eye(len(names)), DETECTOR, {"mug"}, open_voters)
    return found, opened


def test_it_is_not_judged_by_what_it_was_taught(plan: ScenePlan) -> None:
    write_views(plan.views / HOMES / "train-200003.npz", home_views())
    with pytest.raises(RfNavError, match="train-200003: what is judged has learned of this home"):
        measured(plan)


def test_each_kind_is_asked_by_its_own_setting(plan: ScenePlan) -> None:
    found, opened = measured(plan)
    assert [e.settings[0] for e in opened] == [f'research.scene_layout="{k}"' for k in KINDS]
    assert [e.warmed for e in opened] == [2] * 3
    assert set(found.seconds) == set(KINDS)
    assert found.sides["fit"].kinds["head"].rungs == {"head": 2}
    assert found.sides["test"].kinds["head"].regret_m["sle"].tolist() == [5.0, 5.0]
    assert found.sides["test"].kinds["language"].regret_m["sle"].tolist() == [0.0, 0.0]
    assert found.views.areas["view", "taught"]["language"].macro.mean == 1.0
    assert found.views.homes == 3


def test_without_a_bank_there_are_views_and_times(plan: ScenePlan) -> None:
    alone = ScenePlan(plan.views, None, 0, 1, kinds=("head",))
    found, _ = measured(alone)
    assert found.sides == {}
    assert set(found.seconds) == {"head"}
    text = scene_report.section(found, 0)
    assert "In the bank" not in text


def test_views_of_another_detector_are_refused(plan: ScenePlan) -> None:
    assert plan.counted is not None
    for path in sorted((plan.counted / HOMES).glob("*.npz")):
        write_views(path, home_views(detector="another"))
    with pytest.raises(RfNavError, match=r"train: seen by another detector than the one whose"):
        measured(plan)


def test_the_report_says_what_was_measured(plan: ScenePlan) -> None:
    found, _ = measured(plan)
    text = scene_report.section(found, 0)
    assert text.startswith("### On 3 held-out homes\n")
    lines = text.splitlines()
    (view,) = (row for row in lines if row.startswith("| X in view, taught, AUC |"))
    assert view.startswith("| X in view, taught, AUC | ≥ 0.90 | 1.00 [1.00, 1.00] | 1.00 [")
    assert "In the bank, side `test`: 2 questions" in text
    assert "Answered in place" not in text
    tables = [part.splitlines() for part in text.split("\n\n") if part.startswith("|")]
    assert len(tables) == 2 + 2 * 3
    assert all(row.count("|") == rows[0].count("|") for rows in tables for row in rows)
    data = scene_report.figures(found, 0)
    assert data["areas"]["view, taught"]["head"]["macro"]["mean"] == 1.0
    assert data["sides"]["fit"]["kinds"]["head"]["regret_m"]["sle"]["mean"] == 5.0
    assert data["sides"]["fit"]["kinds"]["head"]["absent_m"]["consensus"]["mean"] == 5.0
    assert data["seconds"]["language"]["new_views"] >= 0


def test_what_each_kind_loses_is_beside_what_is_lost_without_sle(plan: ScenePlan) -> None:
    found, _ = measured(plan)
    table = scene_report.section(found, 0).partition("| regret, m |")[2].splitlines()
    pairs = (
        "language minus head", "language minus embedding", "language minus sle absent",
        "head minus embedding", "head minus sle absent", "embedding minus sle absent",
    )  # fmt: skip
    assert columns(table[0]) == [*KINDS, "sle absent", *pairs]
    told = {name: means for name, *means in (columns(row) for row in table[2:5])}
    assert told == {
        "sle": ["0.00", "5.00", "0.00", "–", "-5.00", "0.00", "–", "5.00", "–", "–"],
        # without SLE two disagree, and the closest frontier is the wrong one
        "consensus": ["0.00", "5.00", "0.00", "5.00", "-5.00", "0.00", "-5.00", "5.00", "0.00",
                      "-5.00"],
        "consensus+geometry": ["0.00", "5.00", "0.00", "0.00", "-5.00", "0.00", "0.00", "5.00",
                               "5.00", "0.00"],
    }  # fmt: skip


def columns(row: str) -> list[str]:
    """Cells of a table's row, without their intervals."""
    return [cell.strip(" *").partition(" [")[0] for cell in row.removeprefix("|").split("|")][:-1]


def test_what_evidence_knows_is_beside_what_the_prior_knows(plan: ScenePlan) -> None:
    found, _ = measured(plan)
    side = found.sides["fit"]

    def known(own: float, voted: float) -> Insight:
        return Insight(np.full(2, own), np.array([voted, voted]))

    rows = replace(side.kinds["head"], insight=known(0.2, 0.75), rival=known(0.5, 0.65))
    prior = np.array([0.25, np.nan])  # of the second question nothing is said
    table = scene_report.insight(
        replace(side, kinds={"head": rows}, prior=prior), Resampling(["a", "b"], 0)
    ).splitlines()
    told = dict(zip(columns(table[0]), columns(table[2]), strict=True))
    assert told["way"] == "0.75"
    assert told["minus the prior"] == "0.50"
    assert told["minus r2f"] == "0.10"
    assert (told["way, own"], told["own minus r2f's"]) == ("0.20", "-0.30")
    rival = dict(zip(columns(table[0]), columns(table[3]), strict=True))
    assert (rival["way"], rival["minus the prior"], rival["way, own"]) == ("0.65", "0.40", "0.50")


def test_times_are_told_in_milliseconds(plan: ScenePlan) -> None:
    found, _ = measured(replace(plan, kinds=("head",), bank=None))
    took = replace(found, seconds={"head": SceneSeconds(0.0123, 0.0004)})
    new, known = (columns(row)[:3] for row in scene_report.aims(took, 0).splitlines()[-2:])
    assert new == ["8 frontiers never looked at, 2 threads, ms", "≤ 500", "12.3"]
    assert known == ["the same views, another goal, ms", "≤ 500", "0.4"]


def test_who_answered_instead_is_named(plan: ScenePlan) -> None:
    found, _ = measured(plan)
    found.sides["fit"].kinds["language"].rungs["embedding"] = 1  # type: ignore[index]
    text = scene_report.section(found, 0)
    assert "Answered in place of what was to be judged: language: 1 votes by embedding." in text
