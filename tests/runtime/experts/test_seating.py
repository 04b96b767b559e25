"""Which model answers for an expert: on the robot, in the cloud, or the text encoder."""

import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cloud_double import Server, answer, completion
from manual_clock import ManualClock
from sighted import sight
from taught_layout import ShownModel, TaughtLayout

from runtime.clock import Clock, Deadline, SystemClock
from runtime.core.types import Absence, Ballot, Brief, FrontierBrief, Missing, NearbyObject, Vote
from runtime.core.voting import consensus
from runtime.core.voting.consensus import ConsensusConfig, ConsensusMode
from runtime.core.voting.likelihood_experts import ExpertConfig, SceneRung
from runtime.core.voting.names import ANSWERED_BY
from runtime.core.voting.sight_experts import HEAD
from runtime.experts.cloud import Cloud
from runtime.experts.cloud_config import CloudConfig
from runtime.experts.likelihood import LikelihoodExperts
from runtime.experts.panel import SEATED, Panel
from runtime.experts.reasoner import Reasoner
from runtime.experts.scene_layout import SceneLayoutExperts
from runtime.experts.scorer import Scorer
from runtime.experts.seating import Seating, Unseated

PATIENCE_S = 20.0
CFG = ExpertConfig(scene_layout="embedding")
ROOMS = ("bathroom", "bedroom", "kitchen")
SINK, LAMP = NearbyObject("sink", 0.9, 0.2), NearbyObject("lamp", 0.9, 0.2)
BRIEF = Brief(
    "toilet",
    7,
    (
        FrontierBrief(1, 1.0, (SINK,), (("bathroom", 1.0),), image=b"one"),
        FrontierBrief(2, 2.0, (LAMP,), (("bedroom", 1.0),), image=b"two"),
    ),
)
NO_VIEWS: dict[int, float] = {}


class Likes:
    """A scorer that finds the toilet likely next to a word; it waits at `gate`, if there is one."""

    def __init__(self, word: str, gate: threading.Event | None = None) -> None:
        self.word, self.gate = word, gate
        self.begun = threading.Event()

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        self.begun.set()
        if self.gate is not None:
            assert self.gate.wait(PATIENCE_S)
        likely = self.word in context or "bathroom" in context
        return tuple(-1.0 if likely and c == " toilet" else -5.0 for c in continuations)


class Broken:
    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        raise RuntimeError("no memory")


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def seated(
    stack: ExitStack, model: Any = None, cloud: Cloud | None = None, clock: Clock | None = None
) -> Seating:
    """The text encoder prefers frontier 2, by its lamp; a language model what it is told to."""
    clock = clock or SystemClock()
    below = LikelihoodExperts(
        stack.enter_context(Scorer([("embedding", Likes("lamp"))], clock)), ROOMS
    )
    seats = Seating("small", lambda brief: NO_VIEWS, below, cloud=cloud)
    if model is not None:
        seats.by_likelihood = LikelihoodExperts(
            stack.enter_context(Scorer([("small", model)], clock)), ROOMS
        )
    return seats


def cloud_at(stack: ExitStack, tmp_path: Path, server: Server, **changes: Any) -> Cloud:
    cfg = CloudConfig(
        enabled=True,
        base_url=server.url,
        model="big",
        price_in_usd=0.0,
        price_out_usd=0.0,
        spending_file=str(tmp_path / "spending.sqlite"),
    )
    cloud = stack.enter_context(Cloud(replace(cfg, **changes), SystemClock()))
    cloud.begin("toilet")
    return cloud


def never() -> Deadline:
    return Deadline.never(SystemClock())


def voted(outcome: Vote | Missing) -> tuple[tuple[int, ...], str]:
    assert isinstance(outcome, Vote), outcome
    return outcome.frontiers, outcome.rung


def test_the_model_on_the_robot_answers_first(stack: ExitStack) -> None:
    seats = seated(stack, Likes("sink"))
    table = seats.experts(SEATED, CFG)
    assert voted(table["o2f"](BRIEF, never())) == ((1,), "local")
    assert voted(table["r2f"](BRIEF, never())) == ((1,), "local")
    assert table["sle"](BRIEF, never()) == Missing("sle", Absence.NO_EVIDENCE)
    assert seats.rung() == "small"
    assert not seats.by_embedding.used
    assert seats.appeals(SEATED) == {}
    assert seats.health() == {"rungs": {"o2f": "local", "r2f": "local"}, "errors": []}


def test_a_broken_model_leaves_its_place_to_the_text_encoder(stack: ExitStack) -> None:
    seats = seated(stack, Broken())
    assert voted(seats.experts(SEATED, CFG)["o2f"](BRIEF, never())) == ((2,), "embedding")
    assert seats.rung() == "embedding"
    assert seats.health()["errors"] == ["small: no memory"]


def test_without_a_model_that_answers_the_cloud_is_asked(stack: ExitStack, tmp_path: Path) -> None:
    server = stack.enter_context(Server())
    seats = seated(stack, Broken(), cloud_at(stack, tmp_path, server))
    assert voted(seats.experts(SEATED, CFG)["o2f"](BRIEF, never())) == ((1,), "cloud")
    assert seats.rung() == "cloud"
    assert [bill.outcome for bill in seats.bills()] == ["vote"]
    server.behave = "break"
    assert voted(seats.experts(SEATED, CFG)["o2f"](BRIEF, never())) == ((2,), "embedding")
    status = seats.health()["cloud"]
    assert isinstance(status, dict)
    assert "connection broke" in str(status["error"])


def test_while_the_model_answers_the_cloud_is_not_asked(stack: ExitStack, tmp_path: Path) -> None:
    server = stack.enter_context(Server())
    seats = seated(stack, Likes("sink"), cloud_at(stack, tmp_path, server))
    table = seats.experts(SEATED, CFG)
    for name in ("o2f", "r2f"):
        assert voted(table[name](BRIEF, never())) == ((1,), "local")
    none = Brief("toilet", 8, tuple(FrontierBrief(i, 1.0, (), ()) for i in (1, 2)))
    assert table["o2f"](none, never()) == Missing("o2f", Absence.NO_EVIDENCE)
    assert server.requests == []


def test_a_model_that_hangs_is_stepped_over(stack: ExitStack) -> None:
    clock, gate = ManualClock(), threading.Event()
    model = Likes("sink", gate)
    seats = seated(stack, model, clock=clock)
    got: list[Vote | Missing] = []
    ask = seats.experts(SEATED, CFG)["o2f"]
    asker = threading.Thread(target=lambda: got.append(ask(BRIEF, Deadline.after(2.0, clock))))
    asker.start()
    assert model.begun.wait(PATIENCE_S)
    clock.advance(1.6)  # its share of the two seconds
    asker.join(PATIENCE_S)
    assert voted(got[0]) == ((2,), "embedding")
    clock.advance(10.0)  # now it is known to be stuck, and costs no time any more
    assert voted(ask(BRIEF, Deadline.after(2.0, clock))) == ((2,), "embedding")
    gate.set()
    assert seats.by_likelihood is not None
    assert seats.by_likelihood.scorer.settle(Deadline.never(clock))
    assert voted(ask(BRIEF, Deadline.after(2.0, clock))) == ((1,), "local")


@pytest.mark.parametrize("mode", ["strict", "prior"])
def test_the_cloud_is_appealed_to_when_experts_disagree(
    stack: ExitStack, tmp_path: Path, mode: ConsensusMode
) -> None:
    server = stack.enter_context(Server(lambda body: (200, completion(answer([1])))))
    cloud = cloud_at(stack, tmp_path, server)
    seats = seated(stack, Likes("lamp"), cloud)  # o2f: by the lamp, 2; r2f: the bathroom, 1
    names, rule = ("o2f", "r2f"), ConsensusConfig(mode=mode)

    def agreed(ballot: Ballot) -> bool:
        return consensus.agreed(ballot, rule)

    clock = SystemClock()
    panel = Panel(seats.experts(names, CFG), clock, seats.appeals(names), agreed)
    with stack.enter_context(panel):
        ballot = panel.ask(BRIEF, Deadline.never(clock))
    assert [voted(v) for v in ballot.votes] == [((1,), "cloud"), ((1,), "cloud")]
    assert len(server.requests) == 2
    assert seats.rung() == "cloud"
    cloud.cfg = replace(cloud.cfg, on_disagreement=False)
    assert seats.appeals(names) == {}


def test_an_expert_that_the_cloud_answered_for_does_not_appeal(
    stack: ExitStack, tmp_path: Path
) -> None:
    server = stack.enter_context(Server())
    seats = seated(stack, Broken(), cloud_at(stack, tmp_path, server))
    seats.experts(SEATED, CFG)["o2f"](BRIEF, never())
    appeal = seats.appeals(SEATED)["o2f"]
    assert appeal(BRIEF, never()) == Missing("o2f", Absence.HAS_VOTED)
    assert isinstance(appeal(replace(BRIEF, stamp_ns=8), never()), Vote)
    assert len(server.requests) == 2


class Eyes:
    """Sees the goal in the picture "two", and counts how often it is asked."""

    asked = 0

    def encode(self, image: bytes) -> np.ndarray:
        return np.frombuffer(image, np.uint8)

    def reply(
        self,
        messages: list[dict[str, Any]],
        grammar: str,
        max_tokens: int,
        seconds: float,
        pictures: Sequence[Any] = (),
    ) -> str:
        return answer([2] if "dHdv" in str(messages) else [1])

    def likes(
        self, messages: list[dict[str, Any]], seconds: float, pictures: Sequence[Any]
    ) -> float:
        self.asked += 1
        return 2.0 if "dHdv" in str(messages) else -2.0  # base64 of "two"


def test_sle_asks_the_model_that_sees(stack: ExitStack, tmp_path: Path) -> None:
    seats = seated(stack, Likes("sink"))
    seats.vision = stack.enter_context(Reasoner(Eyes(), SystemClock(), 100, sees=True))
    for in_words in (False, True):
        seats.looks_in_words = in_words
        assert voted(seats.experts(SEATED, CFG)["sle"](BRIEF, never())) == ((2,), "local")
    blind = Brief("toilet", 9, tuple(replace(f, image=b"") for f in BRIEF.frontiers))
    outcome = seats.experts(SEATED, CFG)["sle"](blind, never())
    assert outcome == Missing("sle", Absence.NO_EVIDENCE, "no view of a frontier yet")


def test_a_large_model_reasons_for_the_experts_of_words(stack: ExitStack) -> None:
    seats = seated(stack)
    seats.reasoner = stack.enter_context(Reasoner(Eyes(), SystemClock(), 100, sees=False))
    table = seats.experts(SEATED, CFG)
    assert voted(table["o2f"](BRIEF, never())) == ((1,), "local")
    assert voted(table["r2f"](BRIEF, never())) == ((1,), "local")


def test_with_privacy_text_sle_stays_on_the_robot(stack: ExitStack, tmp_path: Path) -> None:
    server = stack.enter_context(Server())
    seats = seated(stack, Likes("sink"), cloud_at(stack, tmp_path, server))
    seats.likeness = lambda brief: {1: 0.1, 2: 0.9}
    assert voted(seats.experts(SEATED, CFG)["sle"](BRIEF, never())) == ((2,), "embedding")
    assert isinstance(seats.appeals(SEATED)["sle"](BRIEF, never()), Missing)
    assert server.requests == []


SEEN = Brief(
    "toilet",
    10,
    tuple(FrontierBrief(i, 1.0, (), (), sight=sight(0.5, mark=m)) for i, m in ((1, 1), (2, 6))),
)
UNSEEN = Brief("toilet", 11, tuple(replace(f, sight=None) for f in SEEN.frontiers))


def taught(stack: ExitStack, rung: SceneRung, model: Any) -> tuple[Seating, ExpertConfig]:
    seats = seated(stack, model)
    seats.likeness = lambda brief: {1: 0.9, 2: 0.1}
    scorer = seats.by_likelihood.scorer if seats.by_likelihood is not None else None
    seats.layout = SceneLayoutExperts(
        TaughtLayout(),
        lambda text: np.ones(1, np.float32),
        scorer,
        "no words" if scorer is None else "",
    )
    return seats, replace(CFG, scene_layout=rung)


@pytest.mark.parametrize("rung", ["head", "language", "embedding"])
def test_views_are_judged_as_configured_and_by_their_likeness_else(
    stack: ExitStack, rung: SceneRung
) -> None:
    seats, cfg = taught(stack, rung, ShownModel())
    ask = seats.experts(SEATED, cfg)["sle"]
    want = ((1,) if rung == "embedding" else (2,), rung)
    assert voted(ask(SEEN, never())) == want
    assert voted(ask(UNSEEN, never())) == ((1,), "embedding")
    assert seats.health()["errors"] == []
    assert seats.features_from == ("" if rung == "embedding" else "detector")


@pytest.mark.parametrize(("privacy", "rung"), [("full", "cloud"), ("text", "head")])
def test_a_cloud_that_is_sent_pictures_is_asked_before_the_network_that_was_taught_views(
    stack: ExitStack, tmp_path: Path, privacy: str, rung: str
) -> None:
    server = stack.enter_context(Server(lambda body: (200, completion(answer([1])))))
    seats, cfg = taught(stack, "head", None)
    seats.cloud = cloud_at(stack, tmp_path, server, privacy=privacy)
    pictured = replace(SEEN, frontiers=tuple(replace(f, image=b"x") for f in SEEN.frontiers))
    ask = seats.experts(SEATED, cfg)["sle"]
    assert voted(ask(pictured, never())) == ((1,) if rung == "cloud" else (2,), rung)
    assert voted(ask(SEEN, never())) == ((2,), "head")  # of which the cloud has no picture
    assert len(server.requests) == (rung == "cloud")
    server.behave = "break"
    assert voted(ask(replace(pictured, stamp_ns=12), never())) == ((2,), "head")


def test_where_the_language_model_cannot_be_shown_views_the_network_has_a_word_itself(
    stack: ExitStack,
) -> None:
    seats, cfg = taught(stack, "language", Likes("sink"))  # which takes no views
    assert voted(seats.experts(SEATED, cfg)["sle"](SEEN, never())) == ((2,), "head")
    silent, cfg = taught(stack, "language", None)
    assert voted(silent.experts(SEATED, cfg)["sle"](SEEN, never())) == ((2,), "head")
    assert silent.layout_note == "no words"
    assert silent.health()["errors"] == []  # another model than it goes with is no fault


def test_what_cannot_be_opened_is_said_and_the_vote_goes_on(stack: ExitStack) -> None:
    seats, cfg = taught(stack, "head", None)
    seats.layout = Unseated("scene-layout.onnx: no such model file", fault=True)
    assert voted(seats.experts(SEATED, cfg)["sle"](SEEN, never())) == ((1,), "embedding")
    assert seats.health()["errors"] == ["scene-layout.onnx: no such model file"]
    seats.likeness = lambda brief: NO_VIEWS
    outcome = seats.experts(SEATED, cfg)["sle"](SEEN, never())
    why = f"{ANSWERED_BY[HEAD]}: scene-layout.onnx: no such model file"
    assert outcome == Missing("sle", Absence.NO_EVIDENCE, why)
    seats.experts(SEATED, CFG)
    assert seats.health()["errors"] == []  # nobody wants it
    seats.experts(SEATED, cfg)
    seats.experts(("o2f", "r2f"), cfg)
    assert seats.health()["errors"] == []  # SLE has no seat


def test_what_is_forgotten_is_looked_at_again(stack: ExitStack) -> None:
    seats, cfg = taught(stack, "head", None)
    eyes = Eyes()
    seats.vision = stack.enter_context(Reasoner(eyes, SystemClock(), 100, sees=True))
    seen = seats.layout.layout.ways if isinstance(seats.layout, SceneLayoutExperts) else []
    table = seats.experts(SEATED, cfg)
    looks = []
    for forgets in (False, False, True):
        if forgets:
            seats.forget()
        table["sle"](SEEN, never())
        table["sle"](BRIEF, never())
        looks.append((len(seen), eyes.asked))
    assert looks == [(2, 2), (2, 2), (4, 4)]


def test_a_network_for_another_detector_is_noted_and_is_no_fault(stack: ExitStack) -> None:
    seats, cfg = taught(stack, "head", None)
    seats.layout = Unseated("made for another detector")
    assert voted(seats.experts(SEATED, cfg)["sle"](SEEN, never())) == ((1,), "embedding")
    assert seats.layout_note == "made for another detector"
    assert seats.features_from == ""
    assert seats.health()["errors"] == []
