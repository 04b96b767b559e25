"""How a command reaches `rfnav run` on this computer: by the bus that its configuration names."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import zenoh

from runtime.errors import BusError, SilentError
from runtime.robot.json_text import parse_json
from runtime.robot.session import BusConfig, open_session

ANSWER_S = 5.0  # a runtime that is busy takes a frame's time
ANSWER_BYTES = 8 << 20


@dataclass(frozen=True)
class Running:
    """A runtime that may be there."""

    session: Any
    config: BusConfig
    where: str

    def ask(
        self, kind: str, body: Mapping[str, object], within_s: float | None = None
    ) -> dict[str, Any]:
        """The answer to a query on `rfnav/KIND`; BusError, one line, when nobody gives one, and
        SilentError where somebody is there who could."""
        key = self.config.key(f"rfnav/{kind}")
        within_s = ANSWER_S if within_s is None else within_s
        try:
            given = list(self.session.get(key, payload=json.dumps(body), timeout=within_s))
        except zenoh.ZError as error:
            raise BusError(f"{self.where}: {key}: cannot be asked") from error
        answers = [answer.ok for answer in given if answer.ok is not None]
        if given and not answers:  # Zenoh says so of who has promised answers
            raise SilentError(
                f"{self.where}: rfnav run is there, and has not answered on {key} within "
                f"{within_s:g} s: its models still load, or it is busy"
            )
        if not answers:
            raise BusError(f"{self.where}: nobody answers on {key}: is rfnav run up?")
        return parse_json(answers[0].payload.to_bytes(), key, ANSWER_BYTES)


@contextmanager
def running(config: BusConfig) -> Iterator[Running]:
    """BusError, one line, where nobody listens."""
    ends = [end for _, end in config.endpoints]
    plain = [end for end in ends if end.startswith("tcp/")] or ends
    where = plain[0].replace("/0.0.0.0:", "/127.0.0.1:").replace("/[::]:", "/[::1]:")
    there = replace(config, mode="client", connect=(where,), listen=())
    try:
        session = open_session(there)
    except BusError as error:
        raise BusError(
            f"{where}: nobody listens: is rfnav run up? --config names its bus"
        ) from error
    with session:
        yield Running(session, config, where)
