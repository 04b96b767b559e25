"""The runtime of another commit, to be driven in real time beside this one: what its command line
and its keys may lack is left away."""

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hil_sim.driving.link import REPLY_S, Runtime
from runtime.bench.checkout import checkout

HARNESS = "--harness"
ALWAYS = "research.control_mode="  # in real time it is "velocity", whatever that key was called


@contextmanager
def commit(rev: str) -> Iterator[Path]:
    """A commit of this checkout in a folder of its own, its kernels compiled. RfNavError where git
    does not know it, or it does not compile."""
    with checkout(Path(__file__).resolve().parents[2], rev) as root:
        yield root


class OtherRuntime(Runtime):
    """`rfnav run` of a checkout. Its topics are called as they are by default."""

    def __init__(self, root: Path, log: Path, settings: Sequence[str] = ()) -> None:
        command = _module(root, "run")
        known = subprocess.run([*command, "--help"], capture_output=True, text=True, check=False)
        if HARNESS in known.stdout:
            command.append(HARNESS)
        super().__init__(log, None, settings, command, named=False)

    def ask(self, query: str, body: dict[str, object], timeout_s: float = REPLY_S) -> Any:
        settings = body.get("settings")
        if isinstance(settings, list):
            body = {**body, "settings": [s for s in settings if not s.startswith(ALWAYS)]}
        return super().ask(query, body, timeout_s)


def _module(root: Path, *arguments: str) -> list[str]:
    """The command `rfnav` of a checkout, by this installation's Python and packages."""
    path = f"PYTHONPATH={root.resolve()}"
    return ["/usr/bin/env", path, sys.executable, "-P", "-m", "runtime", *arguments]
