"""Where requests are answered: each kind by a function of its own."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

from runtime.robot.requests import Request

Answering = Callable[[Request], Mapping[str, object] | None]
"""What a request is answered; None: later, by whoever has it then."""
NOTHING_ELSE: Final[Mapping[str, Answering]] = MappingProxyType({})


class Desk:
    """`answers`: by a query's kind. One of a kind that nobody answers is refused."""

    def __init__(self, answers: Mapping[str, Answering]) -> None:
        self._answers = answers

    def answer(self, request: Request) -> None:
        """Whatever a request runs into, it is answered; then that is raised."""
        answering = self._answers.get(request.kind)
        if answering is None:
            request.refuse(f"rfnav/{request.kind}: is not answered here")
            return
        try:
            answer = answering(request)
        except Exception as error:
            request.refuse(f"internal error: {error!r}")
            raise
        if answer is not None:
            request.reply(answer)
