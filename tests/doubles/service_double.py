"""A service that answers whatever it is told to."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from click.testing import CliRunner, Result

from hil_sim.driving.link import free_port
from runtime.__main__ import cli
from runtime.robot.session import BusConfig, open_session


class ServiceDouble:
    """`answers`: by kind, None for one that it never gives; `heard`: what was asked."""

    def __init__(self, **answers: dict[str, Any] | None) -> None:
        self.answers, self.heard = answers, list[tuple[str, dict[str, Any]]]()
        self._unanswered: list[Any] = []
        self.end = f"tcp/127.0.0.1:{free_port()}"

    @contextmanager
    def up(self) -> Iterator["ServiceDouble"]:
        """While it is there; again and again."""

        def reply(query) -> None:
            kind = str(query.key_expr).removeprefix("rfnav/")
            self.heard.append((kind, json.loads(query.payload.to_string())))
            if self.answers[kind] is None:
                self._unanswered.append(query)
            else:
                query.reply(query.key_expr, json.dumps(self.answers[kind]))

        with open_session(BusConfig(listen=(self.end,))) as session:
            for kind in self.answers:
                session.declare_queryable(f"rfnav/{kind}", reply)
            yield self
            self._unanswered.clear()

    def run(self, *words: str) -> Result:
        """An `rfnav` command that asks it."""
        return CliRunner().invoke(cli, [*words, "--set", f"bus.listen=['{self.end}']"])
