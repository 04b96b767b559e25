"""Diagnostics, read by MCAP's own reader of ROS 2 messages."""

from drawn_reader import read

from runtime.robot.diagnostics import DIAGNOSTICS, RUNTIME_LEVELS, SILENT_S, Diagnostics
from runtime.robot.messages import StreamHealth

RUNS = {"state": "searching", "cause": ""}


def told(diagnostics: Diagnostics, runtime: dict, streams: dict, now_s: float = 10.0) -> dict:
    message = read(diagnostics.encode(runtime, {"p99": 3.5}, streams, now_s, 7), DIAGNOSTICS)
    assert message.header.stamp.nanosec == 7
    return {status.name: status for status in message.status}


def test_streams_are_well_silent_or_bad():
    streams = {
        "odom": StreamHealth(received=9, arrival_s=9.9),
        "depth": StreamHealth(received=9, arrival_s=9.0 - SILENT_S),
        "color": StreamHealth(),
        "scan": StreamHealth(received=9, bad=2, last_error="scan: no beams", arrival_s=9.9),
    }
    diagnostics = Diagnostics()
    found = told(diagnostics, RUNS, streams)
    assert {name: ord(s.level) if isinstance(s.level, bytes) else s.level
            for name, s in found.items()} == {
        "rfnav: runtime": 0, "rfnav: odom": 0, "rfnav: depth": 3, "rfnav: color": 3,
        "rfnav: scan": 1,
    }  # fmt: skip
    assert found["rfnav: color"].message == "nothing has come"
    assert found["rfnav: depth"].message == "silent for 3 s"
    assert found["rfnav: scan"].message == "scan: no beams"
    values = {pair.key: pair.value for pair in found["rfnav: odom"].values}
    assert (values["received"], values["age (s)"]) == ("9", "0.10")
    again = told(diagnostics, RUNS, streams)["rfnav: scan"]
    assert again.message == "comes"  # nothing bad is new


def test_how_the_runtime_stands_is_a_level_and_its_cause():
    held = told(Diagnostics(), {"state": "held", "cause": "frame: too old"}, {})["rfnav: runtime"]
    assert held.message == "frame: too old"
    assert {pair.key: pair.value for pair in held.values} == {"state": "held", "p99": "3.5"}


def test_every_state_that_is_worth_one_has_a_level():
    from runtime.loops.standing import RunState

    assert set(RUNTIME_LEVELS) <= {state.value for state in RunState}
