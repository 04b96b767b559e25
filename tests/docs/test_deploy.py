"""What is deployed starts a robot, and never what a harness may do."""

from places import ROOT

from hil_sim.driving.link import rfnav_command
from hil_sim.simulation.faults import model_fault, parse_faults

FLAG = "--harness"


def test_nothing_that_is_deployed_has_the_flag():
    files = [path for path in (ROOT / "deploy").rglob("*") if path.is_file()]
    assert files
    for path in files:
        assert FLAG.encode() not in path.read_bytes(), path


def test_the_harness_starts_a_runtime_with_it():
    assert FLAG in rfnav_command()
    assert FLAG in rfnav_command(())
    command, _ = model_fault(parse_faults(("llm-hang",)), ())
    assert command is not None
    assert FLAG in command
