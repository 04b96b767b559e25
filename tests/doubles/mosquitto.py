"""A real broker of MQTT on a port of the loopback, and who listens there as Home Assistant does."""

import shutil
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion

from hil_sim.driving.link import free_port

BROKER = shutil.which("mosquitto", path="/usr/sbin:/usr/bin:/usr/local/sbin:/usr/local/bin")
needs_mosquitto = pytest.mark.skipif(
    BROKER is None, reason="NOT TESTED: no mosquitto here (scripts/setup --all installs it)"
)
SOON_S = 30.0


def waited(for_: Callable[[], Any], what: object = "") -> None:
    until_s = time.monotonic() + SOON_S
    while not for_():
        assert time.monotonic() < until_s, what
        time.sleep(0.02)


class Mosquitto:
    """`lines`: of its configuration, beside the port. It keeps nothing over a restart."""

    def __init__(self, folder: Path, *lines: str) -> None:
        self.port, self._file = free_port(), folder / "mosquitto.conf"
        own = ("user root", "persistence false", f"listener {self.port} 127.0.0.1")
        self._file.write_text("\n".join((*own, *(lines or ("allow_anonymous true",)), "")))

    @contextmanager
    def up(self) -> Iterator["Mosquitto"]:
        assert BROKER is not None
        with subprocess.Popen(
            [BROKER, "-c", str(self._file)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as child:
            try:
                waited(self._answers, "mosquitto did not start")
                yield self
            finally:
                child.terminate()

    def _answers(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0


class Assistant:
    """Hears all, and says what a person does. `kept`: the newest payload by topic; `retained`:
    topics of which the broker had kept one when it came."""

    def __init__(self, port: int, user: str = "", password: str = "", ca: str = "") -> None:
        self.kept: dict[str, str] = {}
        self.retained: set[str] = set()
        self._client = client = Client(CallbackAPIVersion.VERSION2)
        if user:
            client.username_pw_set(user, password)
        if ca:
            client.tls_set(ca)
        client.on_connect = lambda *_: client.subscribe("#", qos=1)
        client.on_message = self._heard
        client.connect("127.0.0.1", port)
        client.loop_start()

    def say(self, topic: str, payload: str | bytes, retain: bool = False) -> None:
        self._client.publish(topic, payload, qos=1, retain=retain).wait_for_publish(SOON_S)

    def hears(self, topic: str, payload: str) -> None:
        waited(lambda: payload in self.kept.get(topic, ""), (topic, payload, self.kept))

    def close(self) -> None:
        self._client.disconnect()
        self._client.loop_stop()
        self._client.on_connect = self._client.on_message = None

    def _heard(self, client: object, data: object, message: Any) -> None:
        self.kept[message.topic] = message.payload.decode("utf-8", "replace")
        if message.retain:
            self.retained.add(message.topic)
