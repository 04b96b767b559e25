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


def service(**other: object) -> dict:
    return {
        "goal": "a mug", "id": "g3", "elapsed_s": 12.34, "driven_m": 3.0, "decisions": 4,
        "queue": [{"goal": "a chair"}], "last": {"sentence": '"sofa" was found', "result": "found"},
        "results": {"found": 2, "cancelled": 1}, "rung": "smollm2-135m", "memory_mb": 512.4,
        "models": {
            "rungs": {"o2f": "cloud"}, "errors": [],
            "cloud": {"goal_usd": 0.01, "day_usd": 0.2, "error": ""},
        },
    } | other  # fmt: skip


def of_service(told: dict) -> dict:
    message = read(Diagnostics().encode(RUNS, {}, {}, 10.0, 7, told), DIAGNOSTICS)
    return {status.name: status for status in message.status}


def test_the_goal_and_the_models_are_told_where_ros_users_look():
    found = of_service(service())
    goal, models = found["rfnav: goal"], found["rfnav: models"]
    assert goal.message == "a mug"
    assert {pair.key: pair.value for pair in goal.values} == {
        "id": "g3", "elapsed (s)": "12.3", "driven (m)": "3.0", "decisions": "4", "waiting": "1",
        "last result": '"sofa" was found', "results": "found 2, cancelled 1",
    }  # fmt: skip
    assert models.message == "smollm2-135m answers"
    assert {pair.key: pair.value for pair in models.values} == {
        "rungs": "o2f cloud", "spent, goal (USD)": "0.01", "spent, day (USD)": "0.2",
        "memory (MB)": "512.4",
    }  # fmt: skip


def test_a_model_that_failed_is_a_warning_and_little_that_is_known_is_told():
    models = {"errors": ["it fell over"], "cloud": {"error": "no network"}}
    told = of_service(service(models=models))["rfnav: models"]
    assert (told.level in (1, b"\x01"), told.message) == (True, "it fell over")
    told = of_service(service(models={"cloud": {"error": "no network"}}))["rfnav: models"]
    assert (told.level in (1, b"\x01"), told.message) == (True, "no network")
    little = of_service({"state": "ready"})
    assert (little["rfnav: goal"].message, little["rfnav: models"].message) == (
        "none", "none answers",
    )  # fmt: skip
