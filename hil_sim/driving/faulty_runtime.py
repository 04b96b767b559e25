"""`python -m hil_sim.driving.faulty_runtime hang|nonsense|cloud-down run --lockstep ...`: the
runtime as it is, with a language model that is at fault, or a cloud that is. It puts the runtime
together anew, so it may import what the rest of driving may not (see `ignore_imports` in
pyproject.toml)."""

import hashlib
import itertools
import math
import socket
import sys
import tempfile
import threading
from collections.abc import Sequence
from pathlib import Path

from runtime import __main__
from runtime.perception import loaded_models


class Hanging:
    """Never answers."""

    identity = "fault: hangs"  # its scores are never taken for a model's
    sha256 = ""  # nor is it shown views

    def __init__(self, path: Path, threads: int = 1) -> None:
        pass

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        threading.Event().wait()
        raise AssertionError("unreachable")


class Babbling:
    """Answers at once, without sense: any number, and now and then none at all."""

    identity = "fault: talks nonsense"
    sha256 = ""

    def __init__(self, path: Path, threads: int = 1) -> None:
        pass

    def score(self, context: str, continuations: Sequence[str]) -> tuple[float, ...]:
        return tuple(nonsense(f"{context}/{text}") for text in continuations)


def nonsense(text: str) -> float:
    """The same for the same text: NaN for one text in eight, else from -1e6 to 0."""
    number = int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")
    return math.nan if number % 8 == 0 else -float(number % 1_000_000)


def down() -> int:
    """The loopback port of an endpoint that hangs up on every other caller, and never answers the
    rest."""
    listener = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        kept: list[socket.socket] = []
        for n in itertools.count():
            caller, _ = listener.accept()
            if n % 2:
                caller.close()
            else:
                kept = [*kept[-7:], caller]  # more do not wait at once

    threading.Thread(target=serve, name="cloud-down", daemon=True).start()
    return int(listener.getsockname()[1])


def cloud_settings(port: int, folder: str) -> list[str]:
    """`--set` values of a runtime that may ask this endpoint: with no key, and a ledger of its
    own."""
    values = {
        "cloud.enabled": "true",
        "cloud.base_url": f"http://127.0.0.1:{port}/v1",
        "cloud.model": "down",
        "cloud.key_file": "''",
        "cloud.credential": "''",
        "cloud.price_in_usd": "1.0",
        "cloud.price_out_usd": "1.0",
        "research.cloud_spending_file": f"{folder}/spending.sqlite",
    }
    return [word for key, value in values.items() for word in ("--set", f"{key}={value}")]


MODELS = {"hang": Hanging, "nonsense": Babbling}
KINDS = (*MODELS, "cloud-down")


def main() -> None:
    """Start the runtime's own command line."""
    if len(sys.argv) < 2 or sys.argv[1] not in KINDS:
        print(f"faulty_runtime: the first word must be one of {', '.join(KINDS)}", file=sys.stderr)
        sys.exit(2)
    kind = sys.argv.pop(1)
    if kind in MODELS:
        loaded_models.LanguageModel = MODELS[kind]  # type: ignore[assignment,attr-defined]
        __main__.main()
        return
    with tempfile.TemporaryDirectory() as folder:
        sys.argv += cloud_settings(down(), folder)
        __main__.main()


if __name__ == "__main__":
    main()
