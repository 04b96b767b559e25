"""Listening to a robot: who is on its bus, and then what the runtime itself would hear and make of
it. Nothing is published."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

from runtime.clock import Clock, Deadline
from runtime.config import Config
from runtime.core.motion.courses import STILL
from runtime.doctor.hearing import Hearing
from runtime.doctor.network import heard_of
from runtime.doctor.reading import Reading
from runtime.robot.bus import Bus
from runtime.robot.session import open_session

NEXT_S: Final = 0.1


def listen(config: Config, seconds: float, clock: Clock) -> Hearing:
    """Hear a robot for so long. BusError when the bus cannot be opened."""
    session: Any = open_session(config.bus)
    try:
        network, advertised = heard_of(session, config)
    finally:
        session.close()
    reading = Reading(config)
    hearing = reading.hearing()
    hearing.network, hearing.advertised = network, advertised
    if network.alone:
        return hearing
    odometry = not config.base.odometry
    known = config.senses, config.safety
    with (
        _reads(reading),
        Bus(config.bus, clock, False, config.camera, odometry=odometry, senses=known[0],
            safety=known[1], serves=False, tap=reading.file) as bus,
    ):  # fmt: skip
        by = Deadline.after(seconds, clock)
        while not by.passed():
            obs = bus.next(min(NEXT_S, by.left_s()))
            if obs is not None:
                reading.seen(obs, clock.now_s())
        halt = bus.doubt(STILL)
        hearing.held = halt.reason if halt else ""
        hearing.errors = {topic: told.last_error for topic, told in bus.health().items()}
    hearing.seconds = seconds
    return hearing


@contextmanager
def _reads(reading: Reading) -> Iterator[None]:
    """Have it read meanwhile; when this is left, all is read."""
    errors: list[Exception] = []

    def run() -> None:
        try:
            reading.run()
        except Exception as error:  # noqa: BLE001 -- raised again below
            errors.append(error)

    thread = threading.Thread(target=run, name="doctor", daemon=True)
    thread.start()
    try:
        yield
    finally:
        reading.close()
        thread.join()
    if errors:
        raise errors[0]
