"""A short search in lockstep through the flat-land apartment, recorded."""

import tempfile
from functools import cache
from pathlib import Path

from fake_models import FakeModels, broken, farthest
from lockstep_double import begin, home, running

from runtime.commands.record import RecordOptions, recording
from runtime.config import load
from runtime.core.types import Action


@cache
def recorded_drive(steps: int = 30) -> Path:
    """The recording of a search for a toilet, of at most so many steps; 0: of no search at all.
    One for all tests of a process, not to be changed."""
    folder = Path(tempfile.mkdtemp())
    there = home()
    there.things = {"toilet": (7.4, 2.2, 0.3)}
    models = FakeModels(there, o2f=farthest, r2f=farthest, sle=broken)
    where = folder / "recorded"
    with (
        recording(load(None), RecordOptions(where, 0.0, False), True, True) as record,
        running(models, record=record) as (peer, ended),
    ):
        peer.ask("status", {})
        if steps:
            assert begin(peer, folder / "log")["accepted"]
        for _ in range(steps):
            action = peer.show(there)
            assert action is not None, ended
            if action == "stop":
                break
            there.apply(Action(action))
        if steps:
            peer.ask("cancel", {"reason": "enough"})
    assert not ended
    (path,) = where.iterdir()
    return path
