"""A large model behind its queue: votes, deadlines, hangs, and pictures asked about once."""

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from manual_clock import ManualClock

from runtime.clock import Deadline, SystemClock
from runtime.core.types import Absence, Brief, FrontierBrief, Missing, NearbyObject, Vote
from runtime.core.voting.likelihood_experts import ExpertConfig
from runtime.experts.reasoner import Late, Reasoner

PATIENCE_S = 20.0
SINK = NearbyObject("sink", 0.9, 0.5)
BRIEF = Brief(
    "toilet",
    0,
    (
        FrontierBrief(4, 1.0, (SINK,), (("bathroom", 1.0),), image=b"tiles"),
        FrontierBrief(9, 2.0, (), (("hall", 1.0),), image=b"carpet"),
        FrontierBrief(11, 3.0, (), (("hall", 1.0),)),
    ),
)


class Model:
    """Says what it is told to say, and notes what it was asked."""

    def __init__(self, say: str | Callable[[], str] = "") -> None:
        self.say = say
        self.asked: list[Any] = []
        self.shown: list[Any] = []
        self.encoded: list[bytes] = []
        self.unfit: tuple[bytes, ...] = ()

    def reply(
        self,
        messages: list[dict[str, Any]],
        grammar: str,
        max_tokens: int,
        seconds: float,
        pictures: Sequence[Any] = (),
    ) -> str:
        self.asked.append((messages, grammar, max_tokens, seconds))
        self.shown.append(pictures)
        return self.say if isinstance(self.say, str) else self.say()

    def encode(self, image: bytes) -> np.ndarray:
        self.encoded.append(image)
        if image in self.unfit:
            raise ValueError("no picture")
        return np.frombuffer(image, np.uint8)

    def likes(
        self, messages: list[dict[str, Any]], seconds: float, pictures: Sequence[Any]
    ) -> float:
        self.asked.append(messages)
        self.shown.append(pictures)
        return 3.0 if "dGlsZXM=" in str(messages) else -1.0  # base64 of "tiles"


def never() -> Deadline:
    return Deadline.never(SystemClock())


def test_a_vote_in_words_held_to_the_frontiers() -> None:
    model = Model('{"reason": "a sink", "frontiers": [4]}')
    with Reasoner(model, SystemClock(), 150, sees=False) as reasoner:
        got = reasoner.expert("o2f")(BRIEF, never())
        assert got == Vote("o2f", (4,), ((4, 1.0), (9, 0.0), (11, 0.0)), "a sink", "local")
        assert reasoner.expert("sle")(BRIEF, never()).cause.startswith("privacy")  # type: ignore[union-attr]
    ((messages, grammar, max_tokens, _),) = model.asked
    assert "sink" in messages[1]["content"]
    assert '"11"' in grammar
    assert max_tokens == 150


def test_each_picture_is_asked_about_once() -> None:
    model = Model()
    with Reasoner(model, SystemClock(), 150, sees=True) as reasoner:
        look = reasoner.look(ExpertConfig())
        for _ in range(3):
            got = look(BRIEF, never())
            assert isinstance(got, Vote)
            assert got.frontiers == (4,)
        assert len(model.asked) == 2
        assert sorted(model.encoded) == [b"carpet", b"tiles"]  # with for ever to wait for it
        assert [bytes(p) for (p,) in model.shown] == [b"tiles", b"carpet"]
        reasoner.forget()
        assert isinstance(look(BRIEF, never()), Vote)
        assert len(model.asked) == 4
        one = Brief("toilet", 0, BRIEF.frontiers[1:])
        assert look(one, never()) == Missing("sle", Absence.NO_IMAGES)


def test_what_is_not_encoded_yet_is_not_waited_for() -> None:
    gate, model = threading.Event(), Model('{"reason": "tiles", "frontiers": [4]}')
    encode = model.encode

    def later(image: bytes) -> np.ndarray:
        assert gate.wait(PATIENCE_S)
        return encode(image)

    model.encode = later  # type: ignore[method-assign]
    clock = ManualClock()
    with Reasoner(model, clock, 150, sees=True) as reasoner:
        look, words = reasoner.look(ExpertConfig()), reasoner.expert("sle")
        soon = Deadline.after(2.0, clock)
        for ask in (look, words):
            assert ask(BRIEF, soon) == Missing(
                "sle", Absence.NO_IMAGES, "of 2 views too few are encoded yet"
            )
        assert model.asked == []
        gate.set()
        assert isinstance(look(BRIEF, Deadline.never(clock)), Vote)
        assert isinstance(words(BRIEF, soon), Vote)  # they are there by now
    messages = str(model.asked[-1][0])
    assert "in which it is somewhere in it" in messages
    assert "red dot" not in messages
    assert sorted(bytes(p) for p in model.shown[-1]) == [b"carpet", b"tiles"]


def test_an_image_that_is_none_is_told_and_the_vote_goes_on_without_it() -> None:
    model = Model()
    model.unfit = (b"carpet",)
    wood = FrontierBrief(12, 3.0, (), (("hall", 1.0),), image=b"wood")
    three = replace(BRIEF, frontiers=(*BRIEF.frontiers, wood))
    with Reasoner(model, SystemClock(), 150, sees=True) as reasoner:
        told = "of 2 views too few are encoded yet; no picture"
        for ask in (reasoner.look(ExpertConfig()), reasoner.expert("sle")):
            assert ask(BRIEF, never()) == Missing(
                "sle", Absence.NO_IMAGES, told
            )  # one is no choice
        assert reasoner.errors == ["no picture"]
        model.say = '{"reason": "tiles", "frontiers": [4]}'
        assert isinstance(reasoner.expert("sle")(three, never()), Vote)
    assert "There is no picture of it." in str(model.asked[-1][0])


def test_what_the_model_raises_reaches_its_asker_alone() -> None:
    def fall_over() -> str:
        raise RuntimeError("out of memory")

    model = Model(fall_over)
    with Reasoner(model, SystemClock(), 150, sees=False) as reasoner:
        with pytest.raises(RuntimeError, match="out of memory"):
            reasoner.expert("o2f")(BRIEF, never())
        model.say = '{"reason": "", "frontiers": [9]}'
        assert isinstance(reasoner.expert("o2f")(BRIEF, never()), Vote)


def test_a_model_that_hangs_is_waited_for_no_longer_than_allowed() -> None:
    clock, called, go = ManualClock(), threading.Event(), threading.Event()

    def hang() -> str:
        called.set()
        assert go.wait(PATIENCE_S)
        return '{"reason": "", "frontiers": [9]}'

    model = Model(hang)
    errors: list[Exception] = []

    def ask() -> None:
        try:
            reasoner.expert("o2f")(BRIEF, Deadline.after(2.0, clock))
        except Late as error:
            errors.append(error)

    with Reasoner(model, clock, 150, sees=False) as reasoner:
        asker = threading.Thread(target=ask)
        asker.start()
        assert called.wait(PATIENCE_S)
        assert reasoner.ready(Deadline.never(clock))  # it may still come
        clock.advance(2.0)
        asker.join(PATIENCE_S)
        assert [str(e) for e in errors] == ["late"]
        assert not reasoner.ready(Deadline.never(clock))
        with pytest.raises(Late):  # nothing stacks up behind it
            reasoner.expert("o2f")(BRIEF, Deadline(clock.now_s(), clock))
        assert len(reasoner._queue) == 0
        go.set()
        with reasoner._condition:
            assert reasoner._condition.wait_for(lambda: reasoner._running is None, PATIENCE_S)
        assert isinstance(reasoner.expert("o2f")(BRIEF, Deadline.never(clock)), Vote)
    assert len(model.asked) == 2


def test_closing_ends_the_encoding_while_a_call_is_under_way() -> None:
    clock, called, encoding = ManualClock(), threading.Event(), threading.Event()
    go, on = threading.Event(), threading.Event()

    def hang() -> str:
        called.set()
        assert go.wait(PATIENCE_S)
        return '{"reason": "", "frontiers": [9]}'

    def ask() -> None:
        with suppress(Late):
            reasoner.expert("o2f")(BRIEF, Deadline.never(clock))

    model, encode = Model(hang), Model().encode
    seen: list[bytes] = []

    def slow(image: bytes) -> np.ndarray:
        seen.append(image)
        encoding.set()
        assert on.wait(PATIENCE_S)
        return encode(image)

    model.encode = slow  # type: ignore[method-assign]
    reasoner = Reasoner(model, clock, 150, sees=True)
    assert reasoner._pictures is not None
    reasoner._pictures.of([b"tiles", b"carpet"], Deadline.after(1.0, clock))
    asker = threading.Thread(target=ask)
    closer = threading.Thread(target=reasoner.close)
    asker.start()
    assert called.wait(PATIENCE_S)
    assert encoding.wait(PATIENCE_S)
    closer.start()
    with reasoner._pictures._condition:
        told = reasoner._pictures._condition.wait_for(lambda: reasoner._pictures._closed, 2.0)
    on.set()
    go.set()
    for thread in (asker, closer):
        thread.join(PATIENCE_S)
    assert told
    assert seen == [b"tiles"]
