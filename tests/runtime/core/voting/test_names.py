"""How experts and rules are called for a person."""

import re
from typing import get_args

import pytest
from places import ROOT

from runtime.core.voting.consensus import ConsensusMode, Fallback
from runtime.core.voting.names import ANSWERED_BY, WHO, introduced, rule_said, who
from runtime.experts.cloud import RUNG
from runtime.experts.panel import EXPERTS
from runtime.experts.seating import COUNTS, EMBEDDING, HEAD, LANGUAGE, LOCAL, TOGETHER
from runtime.robot.told_votes import TOLD

WORDS = ROOT / "runtime/view/page/words.js"
SETS = ("all", "pairs", "lone", "majority")  # rules that are no mode


def test_experts_and_rungs_are_those_that_there_are():
    assert set(WHO) == set(EXPERTS)
    models = {LOCAL, RUNG, LANGUAGE, HEAD, EMBEDDING}
    assert set(ANSWERED_BY) == {*models, COUNTS, TOGETHER, TOLD}


def test_the_page_calls_experts_by_the_same_names():
    table = re.search(r"WHO = \{(.*?)\};", WORDS.read_text(encoding="utf-8"), re.DOTALL)
    assert table is not None
    found = dict(re.findall(r'(\w+): "([^"]+)"', table[1]))
    assert {expert: name.lower() for expert, name in found.items()} == WHO


def test_an_expert_that_nobody_knows_keeps_its_name():
    assert (who("o2f"), introduced("o2f")) == ("objects near by", "objects near by (o2f)")
    assert (who("mine"), introduced("mine")) == ("mine", "mine")


@pytest.mark.parametrize("rule", [*SETS, *get_args(Fallback), "prior", "weighted", "best"])
def test_every_rule_has_words(rule: str):
    assert " " in rule_said(rule)
    assert rule_said(rule) != rule_said("some_rule") == "some rule"


def test_modes_that_elect_by_themselves_are_among_the_rules():
    rules = {mode.partition("-")[0] for mode in get_args(ConsensusMode)} - {"strict", "lenient"}
    assert all(" " in rule_said(rule) for rule in rules)


def test_a_planned_order_has_another_reason_than_one_step():
    assert "soonest in the mean" in rule_said("prior", planned=True)
    assert "the most to find for the way there" in rule_said("prior")
    assert rule_said("all", planned=True) == rule_said("all")
