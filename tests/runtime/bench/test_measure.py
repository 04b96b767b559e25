"""A run of the bench."""

import pytest

from runtime.bench import measure, synthetic
from runtime.bench.measure import BenchError, Subject
from runtime.config import load
from runtime.tracing.stages import Stage


@pytest.mark.slow
def test_a_run_from_start_to_end():
    config = load(None, ())
    drive = synthetic.drive(8.0, config.bus.topics, config.camera)
    found = measure.measured(Subject(), "toilet", drive, config.bus.topics, 20.0)
    assert {Stage.LATE, Stage.TICK, Stage.FRAME, Stage.SURVEY, Stage.DETECT} <= set(found.stages)
    assert found.stages[Stage.TICK]["n"] > 20
    assert 0 < found.ready_s < 60
    assert found.first_command_s is not None
    assert found.memory_mb > 100
    assert found.sleeper["n"] > 20


def test_a_runtime_that_ends_is_told_of_in_a_line_with_what_it_said():
    config = load(None, ())
    wrong = Subject(("--set", "camera.hight_m=1"))
    with pytest.raises(BenchError, match=r"the runtime ended and said: rfnav: .*hight_m"):
        measure.measured(wrong, "toilet", iter(()), config.bus.topics, 20.0)
