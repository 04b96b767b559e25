"""`python -m hil_sim.faulty_runtime hang|nonsense run --lockstep ...`: the runtime as it is, with a
language model that is at fault. The harness's own composition root, and the one module of it that
may reach into the runtime."""

import hashlib
import math
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from runtime import __main__, mind


class Hanging:
    """Never answers."""

    identity = "fault: hangs"  # its scores are never taken for a model's

    def __init__(self, path: Path, threads: int = 1) -> None:
        pass

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        threading.Event().wait()
        raise AssertionError("unreachable")


class Babbling:
    """Answers at once, without sense: any number, and now and then none at all."""

    identity = "fault: talks nonsense"

    def __init__(self, path: Path, threads: int = 1) -> None:
        pass

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        return tuple(nonsense(f"{context}/{text}") for text in continuations)


def nonsense(text: str) -> float:
    """The same for the same text: NaN for one text in eight, else from -1e6 to 0."""
    number = int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")
    return math.nan if number % 8 == 0 else -float(number % 1_000_000)


MODELS = {"hang": Hanging, "nonsense": Babbling}


def main() -> None:
    """Start the runtime's own command line."""
    if len(sys.argv) < 2 or sys.argv[1] not in MODELS:
        print(f"faulty_runtime: the first word must be {' or '.join(MODELS)}", file=sys.stderr)
        sys.exit(2)
    mind.LanguageModel = MODELS[sys.argv.pop(1)]  # type: ignore[assignment,attr-defined]
    __main__.main()


if __name__ == "__main__":
    main()
