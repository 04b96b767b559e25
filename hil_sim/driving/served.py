"""`rfnav run` as a child beside a robot that lives, for whoever wants to try what it is asked."""

import json
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import zenoh

from hil_sim.driving.child import end, last_line, spawn
from hil_sim.driving.link import HarnessError
from runtime.errors import SensorError
from runtime.robot.json_text import parse_json
from runtime.robot.session import STATUS, BusConfig, open_session

ASK_S: Final = 0.5  # between two questions whether it is up
ENDS_S: Final = 20.0  # what it knows is written when it ends
STATE, LOG, CONFIG = "state", "rfnav.log", "robot.toml"


def served_command(
    state: Path, endpoint: str, config: Path | None, settings: Sequence[str], more: Sequence[str]
) -> list[str]:
    """This installation's `rfnav run`, as a robot's owner starts it. `more`: options of it."""
    command = ["/usr/bin/env", f"STATE_DIRECTORY={state}", sys.executable, "-m", "runtime", "run"]
    command += [*more, *(("--config", str(config)) if config is not None else ())]
    for setting in (f'bus.connect=["{endpoint}"]', "bus.listen=[]", *settings):
        command += ["--set", setting]
    return command


class Served:
    """The child of that command, on the bus of `endpoint`; its log is `log`. `ready` is set when it
    takes goals."""

    def __init__(self, command: Sequence[str], endpoint: str, log: Path) -> None:
        self._log, self.ready, self._ending = log, threading.Event(), threading.Event()
        self._session: Any = open_session(BusConfig(mode="client", connect=(endpoint,)))
        self._asking = threading.Thread(target=self._ask, daemon=True)
        self._child = spawn(command, log)
        self._asking.start()

    def check(self) -> None:
        """HarnessError, with its own last line, when it has ended by itself."""
        status = self._child.poll()
        if status is not None:
            why = last_line(self._log) or "it said nothing"
            raise HarnessError(f"rfnav run ended with status {status}: {why} ({self._log})")

    def close(self, meanwhile: Callable[[], None]) -> None:
        """Have it end, and do something again and again until it has. Idempotent."""
        self._ending.set()
        if self._child.poll() is None:
            self._child.send_signal(signal.SIGTERM)
        until_s = time.monotonic() + ENDS_S
        while self._child.poll() is None and time.monotonic() < until_s:
            meanwhile()
        self.kill()

    def kill(self) -> None:
        """Whatever it does. Idempotent."""
        self._ending.set()
        end(self._child)
        self._asking.join(ASK_S + 1.0)
        if not self._session.is_closed():
            self._session.close()

    def _ask(self) -> None:
        while not self._ending.wait(ASK_S):
            with suppress(zenoh.ZError, SensorError):
                for reply in self._session.get(STATUS, payload=json.dumps({}), timeout=ASK_S):
                    if reply.ok is None:
                        continue
                    stands = parse_json(reply.ok.payload.to_bytes(), STATUS).get("runtime")
                    if isinstance(stands, dict) and stands.get("state") != "starting":
                        self.ready.set()
                        return
