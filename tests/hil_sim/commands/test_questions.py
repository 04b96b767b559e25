"""`hil-sim questions` from the outside: what it refuses, and what it leaves in a document."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from asked import moment
from click.testing import CliRunner
from looked import DETECTOR, write_homes
from manual_clock import ManualClock

from hil_sim.commands.questions import questions_command
from hil_sim.expert_bench import voting
from hil_sim.expert_bench.bank import HOMES, PLAN_FILE, BankHome, BankPlan, write_home
from hil_sim.expert_bench.make import make_bank, plan_of
from hil_sim.expert_bench.view_questions import Floats, SightRows
from runtime.clock import Deadline
from runtime.core.types import Absence, Brief, Missing, Vote
from runtime.errors import RfNavError
from runtime.experts.panel import EXPERTS
from runtime.perception import beholders


class Mute:
    """Voters of whom none votes."""

    def __init__(self, settings: tuple[str, ...] = ()) -> None:
        self.settings = settings

    def __enter__(self) -> "Mute":
        return self

    def __exit__(self, *_: object) -> None: ...

    def warm(self, bank: object, briefs: object) -> None: ...

    def asked(self, config: object, questions: object) -> voting.Votes:
        table = {e: (lambda brief, by, e=e: Missing(e, Absence.NO_EVIDENCE)) for e in EXPERTS}
        return voting.Votes(table, questions, Deadline.never(ManualClock()))

    def check(self) -> None: ...


@pytest.fixture
def bank(tmp_path: Path) -> Path:
    folder = tmp_path / "bank"
    make_bank(folder, [], BankPlan(), 1)
    for name in ("train-100000", "train-100001"):
        write_home(folder / HOMES / f"{name}.jsonl.gz", BankHome(name, (moment(name),), {}, "e"))
    return folder


def run(*arguments: str):
    return CliRunner().invoke(questions_command, arguments)


def test_tables_are_put_between_markers_and_come_out_the_same(
    bank: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(voting, "Voters", Mute)
    out, figures = tmp_path / "experts.md", tmp_path / "figures.json"
    out.write_text("# Ours\n\nkept\n", encoding="utf-8")
    asked = ("--bank", str(bank), "--homes", "0", "--quick", "--out", str(out))
    done = run(*asked, "--side", "fit", "--json", str(figures))
    assert done.exit_code == 0, done.output
    first = out.read_text(encoding="utf-8")
    assert first.startswith("# Ours\n\nkept\n")
    assert "<!-- report questions-fit -->" in first
    assert "| closest | 5.00 [5.00, 5.00] |" in first
    assert json.loads(figures.read_text())["votes"]["o2f"] == {"no evidence": 1.0}
    assert run(*asked, "--side", "fit").exit_code == 0
    assert out.read_text(encoding="utf-8") == first
    assert run(*asked, "--side", "test").exit_code == 0
    assert out.read_text(encoding="utf-8").startswith(first.rstrip())


def test_a_bank_is_not_mixed(bank: Path) -> None:
    with pytest.raises(RfNavError, match=r"bank\.json: was made with other seed, steps"):
        make_bank(bank, [], BankPlan(seed=1, steps=50), 1)
    assert plan_of(bank) == BankPlan()


@pytest.mark.parametrize(
    ("text", "said"),
    [("{", "not a plan of homes"), ('{"sed": 1}', "not a plan of homes"), (None, "no such file")],
)
def test_a_folder_that_is_no_bank_is_refused(tmp_path: Path, text: str | None, said: str) -> None:
    if text is not None:
        (tmp_path / PLAN_FILE).write_text(text)
    done = run("--bank", str(tmp_path), "--homes", "0", "--side", "all", "--tell-again")
    assert isinstance(done.exception, RfNavError)
    assert said in str(done.exception)
    assert "\n" not in str(done.exception)


@pytest.mark.parametrize(("seed", "home"), [(1, "train-200000"), (8, "train-900000")])
def test_no_bank_is_made_of_homes_that_experts_have_learned_of(
    tmp_path: Path, seed: int, home: str
) -> None:
    done = run("--bank", str(tmp_path), "--homes", "2", "--seed", str(seed), "--side", "none")
    assert isinstance(done.exception, RfNavError)
    assert str(done.exception).startswith(f"{home}: what is judged has learned of this home")
    assert not list(tmp_path.iterdir())


def test_an_empty_bank_says_how_to_make_one(tmp_path: Path) -> None:
    done = run("--bank", str(tmp_path), "--homes", "0")
    assert isinstance(done.exception, RfNavError)
    assert "make them: hil-sim questions" in str(done.exception)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ((), "--bank is needed"),
        (("--expert", "sle"), "--expert needs --views"),
    ],
)
def test_what_is_needed_is_said(asked: tuple[str, ...], said: str) -> None:
    done = run(*asked)
    assert done.exit_code == 2
    assert said in done.output


class Blind:
    """Sees nothing in any picture."""

    def evidence(self, about: object, sights: SightRows, names: Sequence[str]) -> Floats:
        return np.zeros((len(sights), len(names)))


class Voting(Mute):
    """Of whom SLE votes for the first frontier, and no one else does."""

    def warm(self, bank: object, briefs: object = ()) -> None: ...

    def asked(self, config: object, questions: object) -> voting.Votes:
        def sle(brief: Brief, by: Deadline) -> Vote:
            ids = [f.id for f in brief.frontiers]
            return Vote("sle", (ids[0],), tuple((i, 1.0) for i in ids), "given", "head")

        table = {e: (lambda brief, by, e=e: Missing(e, Absence.NO_EVIDENCE)) for e in EXPERTS}
        return voting.Votes({**table, "sle": sle}, questions, Deadline.never(ManualClock()))


def test_an_expert_is_judged_by_itself(
    bank: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = beholders.Opened({"head": Blind()}, lambda names: np.eye(len(names)), DETECTOR)
    monkeypatch.setattr(beholders, "open_beholders", lambda kinds, models: opened)
    monkeypatch.setattr(voting, "Voters", Voting)
    dev, out = write_homes(tmp_path / "dev", homes=3, rows=64), tmp_path / "doc.md"
    asked = ("--expert", "sle", "--kind", "head", "--rows", "0", "--views", str(dev),
             "--counted", str(dev), "--plans", "1")  # fmt: skip
    figures = tmp_path / "figures.json"
    done = run(*asked, "--out", str(out), "--json", str(figures))
    assert done.exit_code == 0, done.output
    text = out.read_text(encoding="utf-8")
    assert "<!-- report questions-sle -->" in text
    assert "| X in view, taught, AUC | ≥ 0.90 | 0.50 [0.50, 0.50] |" in text
    assert json.loads(figures.read_text(encoding="utf-8"))["homes"] == 3
    banked = run(*asked, "--bank", str(bank), "--homes", "0", "--side", "all")
    assert banked.exit_code == 0, banked.output
    assert "#### In the bank, side `fit`: " in banked.output
    assert "#### In the bank, side `test`: " in banked.output


class Unsure(Mute):
    """Of whom nobody votes, of what was never counted either."""

    def warm(self, bank: object, briefs: object = ()) -> None: ...

    def guessing(self, config: object, questions: object) -> voting.Votes:
        return self.asked(config, questions)


def test_kinds_of_evidence_have_a_block_of_their_own(
    bank: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(voting, "Voters", Unsure)
    out, figures = tmp_path / "experts.md", tmp_path / "figures.json"
    asked = ("--bank", str(bank), "--homes", "0", "--side", "fit", "--evidence")
    done = run(*asked, "--out", str(out), "--json", str(figures))
    assert done.exit_code == 0, done.output
    told = out.read_text(encoding="utf-8")
    assert "<!-- report questions-evidence-fit -->" in told
    assert "| o2f, counts | 0.0 | – | – | – | 0.00 [0.00, 0.00] |" in told
    row = json.loads(figures.read_text())["rows"]["o2f, counts"]
    assert row["voted"] == 0.0
    assert row["rules"]["paper"]["gained_m"]["mean"] == 0.0
