"""Everything about the scene-layout expert at once, with experts and views whose answers are
known."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import numpy as np
import pytest
from asked import moment
from looked import write_homes
from manual_clock import ManualClock

from hil_sim.expert_bench import scene_report
from hil_sim.expert_bench.bank import HOMES, Bank, BankHome, write_home
from hil_sim.expert_bench.scene import measure
from hil_sim.expert_bench.scene_plan import KINDS, ScenePlan
from hil_sim.expert_bench.scene_report import SceneFigures
from hil_sim.expert_bench.view_questions import Floats, SightRows
from hil_sim.expert_bench.voting import Votes
from runtime.clock import Deadline
from runtime.config import Config
from runtime.core.types import Brief, Missing, Vote
from runtime.experts.panel import EXPERTS


class Sighted:
    """It sees what the first feature tells of beds."""

    def evidence(self, about: object, sights: SightRows, names: Sequence[str]) -> Floats:
        known = np.array([name in ("bed", "bedroom") for name in names], float)
        return sights.features[:, 0, 0, 0].astype(float)[:, None] * known


class Electors:
    """All vote for the last frontier, SLE by the kind that is asked for."""

    def __init__(self, settings: Sequence[str]) -> None:
        self.settings, self.warmed = settings, 0

    def warm(self, bank: Bank) -> None:
        self.warmed += 1

    def asked(self, config: Config, questions: Sequence[object]) -> Votes:
        def vote(expert: str, brief: Brief) -> Vote | Missing:
            ids = [f.id for f in brief.frontiers]
            rung = config.experts.scene_layout if expert == "sle" else "local"
            return Vote(expert, (ids[-1],), tuple((i, i + 1.0) for i in ids), "given", rung)

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
    return ScenePlan(dev, train, 0, bank=bank, sides=("fit", "test"))


def measured(plan: ScenePlan) -> tuple[SceneFigures, list[Electors]]:
    opened = list[Electors]()

    def open_voters(settings: Sequence[str]) -> AbstractContextManager[Electors]:
        opened.append(Electors(settings))
        return nullcontext(opened[-1])

    kinds: Mapping[str, Sighted] = {kind: Sighted() for kind in plan.kinds}
    found = measure(plan, kinds, lambda names: np.eye(len(names)), {"mug"}, open_voters)
    return found, opened


def test_each_kind_is_asked_by_its_own_setting(plan: ScenePlan) -> None:
    found, opened = measured(plan)
    assert [e.settings[0] for e in opened] == [f'research.scene_layout="{k}"' for k in KINDS]
    assert [e.warmed for e in opened] == [2] * 3
    assert set(found.seconds) == set(KINDS)
    assert found.sides["fit"].kinds["head"].rungs == {"head": 2}
    assert found.sides["test"].kinds["head"].regret_m["sle"].tolist() == [0.0, 0.0]
    assert found.views.areas["view", "taught"]["language"].macro.mean == 1.0
    assert found.views.homes == 3


def test_without_a_bank_there_are_views_and_times(plan: ScenePlan) -> None:
    alone = ScenePlan(plan.views, plan.counted, 0, kinds=("head",))
    found, _ = measured(alone)
    assert found.sides == {}
    assert set(found.seconds) == {"head"}
    text = scene_report.section(found, 0)
    assert "In the bank" not in text


def test_the_report_says_what_was_measured(plan: ScenePlan) -> None:
    found, _ = measured(plan)
    text = scene_report.section(found, 0)
    assert text.startswith("### On 3 held-out homes\n")
    lines = text.splitlines()
    (view,) = (row for row in lines if row.startswith("| X in view, taught, AUC |"))
    assert view.startswith("| X in view, taught, AUC | ≥ 0.90 | 1.00 [1.00, 1.00] | 1.00 [")
    (gate, _) = (row for row in lines if row.startswith("| sle | 0.00"))
    assert gate.count("0.00 [0.00, 0.00]") == 6
    assert "In the bank, side `test`: 2 questions" in text
    assert "Answered in place" not in text
    tables = [part.splitlines() for part in text.split("\n\n") if part.startswith("|")]
    assert len(tables) == 2 + 2 * 2
    assert all(row.count("|") == rows[0].count("|") for rows in tables for row in rows)
    data = scene_report.figures(found, 0)
    assert data["areas"]["view, taught"]["head"]["macro"]["mean"] == 1.0
    assert data["sides"]["fit"]["kinds"]["head"]["regret_m"]["sle"]["mean"] == 0.0
    assert data["seconds"]["language"]["new_views"] >= 0


def test_who_answered_instead_is_named(plan: ScenePlan) -> None:
    found, _ = measured(plan)
    found.sides["fit"].kinds["language"].rungs["embedding"] = 1  # type: ignore[index]
    text = scene_report.section(found, 0)
    assert "Answered in place of what was to be judged: language: 1 votes by embedding." in text
