"""Experts that ask a model elsewhere, by an OpenAI-compatible endpoint: only when the configuration
allows it, in the time and money left, and with the images that privacy allows.

Failures are abstentions with a cause. After one that is not the question's fault the endpoint is
left alone for a while, so that a cloud that is down costs no decision its time.
"""

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Self

from runtime.clock import Clock, Deadline
from runtime.core.types import Absence, Brief, Missing, Vote
from runtime.core.voting import prompted_experts
from runtime.experts.cloud_config import CloudConfig, check, read_key
from runtime.experts.endpoint import CallFailed, Endpoint, Reply
from runtime.experts.panel import Expert
from runtime.experts.spending import (
    NANO,
    CapReached,
    Caps,
    Prices,
    Spending,
    SpendingError,
    default_path,
)

RUNG = "cloud"
SPARE_S = 0.05  # of the time left, for what follows the call
SHORTEST_S = 0.3  # with less time left no call is begun
LONGEST_BACKOFF_S = 60.0
MESSAGE_TOKENS = 32  # that a server may add around a message


@dataclass(frozen=True)
class Bill:
    """One call, for the journal: tokens as the endpoint counts them, else None."""

    expert: str
    model: str
    outcome: str  # "vote", or why there was none
    usd: float
    tokens_in: int | None
    tokens_out: int | None
    images: int
    took_s: float


class Cloud:
    """The endpoint, its ledger, and the experts that ask it. Threads may share it."""

    def __init__(self, cfg: CloudConfig, clock: Clock) -> None:
        check(cfg)
        self.cfg, self._clock = cfg, clock
        path = Path(cfg.spending_file) if cfg.spending_file else default_path()
        self._prices = Prices(cfg.price_in_usd, cfg.price_out_usd)
        self._spending = Spending(path, Caps(cfg.cap_goal_usd, cfg.cap_day_usd))
        self._endpoint = Endpoint(cfg.base_url, cfg.model, read_key(cfg))
        self._lock = threading.Lock()
        self._rest_until_s, self._failures = -1e9, 0
        self._bills: deque[Bill] = deque(maxlen=100)
        self._calls, self._error, self._spent = 0, "", (0.0, 0.0)
        self._run_usd = 0.0  # since the process began

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections. The goal's account stays open: a restart may go on with it."""
        self._endpoint.close()

    def begin(self, goal: str) -> None:
        """A new goal, with a cap of its own."""
        self._book(partial(self._spending.begin, goal))

    def afford(self, usd: float | None) -> None:
        """The goal may cost no more than that, nor than its cap."""
        self._spending.afford(math.inf if usd is None else usd)

    def finish(self) -> None:
        """The goal is done with."""
        self._book(self._spending.finish)

    def expert(self, name: str) -> Expert:
        """The expert of that name, as the cloud's model answers for it."""
        return partial(self._ask, name)

    def ready(self, by: Deadline) -> bool:
        """Whether a call begun now could be of use: there is time, and the endpoint not at rest."""
        with self._lock:
            resting = self._clock.now_s() < self._rest_until_s
        return not resting and by.left_s() >= SHORTEST_S + SPARE_S

    def bills(self) -> tuple[Bill, ...]:
        """The calls since this was asked last."""
        with self._lock:
            bills = tuple(self._bills)
            self._bills.clear()
        return bills

    def status(self) -> dict[str, object]:
        """For people: calls and US dollars so far, and what went wrong last."""
        with self._lock:
            goal_usd, day_usd = self._spent
            return {
                "model": self.cfg.model,
                "calls": self._calls,
                "goal_usd": round(goal_usd, 6),
                "day_usd": round(day_usd, 6),
                "run_usd": round(self._run_usd, 6),
                "error": self._error,
            }

    # -- one call --------------------------------------------------------------------------------

    def _ask(self, name: str, brief: Brief, by: Deadline) -> Vote | Missing:
        if not self.ready(by):
            with self._lock:
                resting = self._clock.now_s() < self._rest_until_s
                if resting:
                    return Missing(name, Absence.AT_REST, self._error)
                return Missing(name, Absence.NO_TIME)
        prompt = prompted_experts.compose(name, brief, self.cfg.sends_images)
        if isinstance(prompt, Missing):
            return prompt
        try:
            booking = self._spending.reserve(self._worst(prompt), name)
        except (CapReached, SpendingError) as error:
            with self._lock:
                self._error = str(error)
            return Missing(name, Absence.NOT_AFFORDED, str(error))
        return self._call(prompt, booking, by)

    def _call(self, prompt: prompted_experts.Prompt, booking: int, by: Deadline) -> Vote | Missing:
        began_s = self._clock.now_s()
        within_s = min(self.cfg.timeout_s, by.left_s() - SPARE_S)
        cost: int | None = None  # what was reserved, if nothing better is known
        reply = None
        outcome: Vote | Missing
        try:
            reply = self._endpoint.chat(
                prompted_experts.chat(prompt.messages),
                prompted_experts.schema(prompt.ids),
                self.cfg.reply_tokens,
                within_s,
            )
            outcome = prompted_experts.read(reply.text, prompt.expert, prompt.ids, RUNG)
            self._note(None)
            if reply.tokens_in is not None and reply.tokens_out is not None:
                cost = self._prices.nano(reply.tokens_in, reply.tokens_out)
        except CallFailed as error:
            outcome = Missing(prompt.expert, Absence.CALL_FAILED, str(error))
            self._note(error)
            cost = None if error.billable else 0
        finally:
            booked = self._settle(booking, cost)
        self._bill(prompt, outcome, reply, booked, self._clock.now_s() - began_s)
        return outcome

    def _worst(self, prompt: prompted_experts.Prompt) -> int:
        """The most that a call can cost, nano-dollars: a byte of text makes a token at most, and
        the schema may be billed as text."""
        told = prompt.text_bytes + len(str(prompted_experts.schema(prompt.ids)))
        tokens_in = told + prompt.images * self.cfg.image_tokens
        tokens_in += MESSAGE_TOKENS * len(prompt.messages)
        return self._prices.nano(tokens_in, self.cfg.reply_tokens)

    def _settle(self, booking: int, cost: int | None) -> float:
        booked = 0
        try:
            booked = self._spending.settle(booking, cost)
            spent = self._spending.spent()
            with self._lock:
                self._spent = spent
        except SpendingError as error:  # the reservation stands; the next one will be refused
            with self._lock:
                self._error = str(error)
        return booked / NANO

    def _book(self, step: Callable[[], None]) -> None:
        """Begin or end an account; a ledger that cannot be used refuses reservations later."""
        try:
            step()
            spent = self._spending.spent()
            with self._lock:
                self._spent = spent
        except SpendingError as error:
            with self._lock:
                self._error = str(error)

    def _note(self, error: CallFailed | None) -> None:
        """Remember how a call went, and how long to leave the endpoint alone."""
        with self._lock:
            now_s = self._clock.now_s()
            self._calls += 1
            if error is None:
                self._failures = 0
                return
            self._error = str(error)
            if error.transient and now_s >= self._rest_until_s:  # calls at once count as one
                self._failures += 1
                backoff_s = min(LONGEST_BACKOFF_S, 2.0 ** (self._failures - 1))
                self._rest_until_s = now_s + max(backoff_s, error.rest_s)

    def _bill(
        self,
        prompt: prompted_experts.Prompt,
        outcome: Vote | Missing,
        reply: Reply | None,
        usd: float,
        took_s: float,
    ) -> None:
        told = outcome.cause if isinstance(outcome, Missing) else "vote"
        tokens = (reply.tokens_in, reply.tokens_out) if reply else (None, None)
        model = self.cfg.model
        bill = Bill(
            prompt.expert, model, told, round(usd, 9), *tokens, prompt.images, round(took_s, 3)
        )
        with self._lock:
            self._bills.append(bill)
            self._run_usd += usd
