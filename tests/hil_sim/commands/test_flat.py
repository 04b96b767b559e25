"""`hil-sim flat` from the outside."""

from click.testing import CliRunner
from plan_of_rooms import three_rooms

from hil_sim.commands.flat import flat_command
from hil_sim.expert_bench import flat_bench
from runtime.errors import RfNavError


def test_it_prints_a_row_for_each_method(monkeypatch):
    monkeypatch.setattr(flat_bench, "open_scene", lambda name: three_rooms())
    told = CliRunner().invoke(flat_command, ["--homes", "2", "--goals", "1", "--method", "ahead"])
    assert told.exit_code == 0, told.output
    rows = [line for line in told.stdout.splitlines() if line.startswith("| ")]
    assert [row.split(" | ")[0] for row in rows[1:]] == [
        f"| {flat_bench.ORACLE}", "| geometry", "| ahead",
    ]  # fmt: skip


def test_a_method_that_there_is_not_is_refused_with_those_that_there_are():
    told = CliRunner().invoke(flat_command, ["--method", "luck"])
    assert told.exit_code == 2
    assert "--method luck: unknown; known: closest, geometry" in told.output


def test_homes_that_were_counted_are_not_searched():
    told = CliRunner().invoke(flat_command, ["--first", "899999", "--homes", "2"])
    assert isinstance(told.exception, RfNavError)
    assert str(told.exception).startswith("train-900000: what is judged has learned of this home")


def test_homes_without_a_task_are_told_of(monkeypatch):
    monkeypatch.setattr(flat_bench, "GOALS", ("piano",))
    monkeypatch.setattr(flat_bench, "open_scene", lambda name: three_rooms())
    told = CliRunner().invoke(flat_command, ["--homes", "1", "--method", "ahead"])
    assert isinstance(told.exception, RfNavError)
    assert "take more, --homes" in str(told.exception)
