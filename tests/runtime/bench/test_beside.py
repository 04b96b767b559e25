"""A server with clients beside it: up before they are, both ended in the end."""

import os
import sys
import time
from pathlib import Path

import pytest

from runtime.bench.beside import ServerCost, cpu_s, served
from runtime.bench.measure import BenchError

SERVES = [sys.executable, "-c", "print('up', flush=True); import time; time.sleep(600)"]
ENDS = [sys.executable, "-c", "pass"]


@pytest.fixture(autouse=True)
def settled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("runtime.bench.beside.SETTLES_S", 0.0)


def test_what_it_cost_is_told_in_the_end():
    costs: list[ServerCost] = []
    with served(SERVES, SERVES, costs):
        assert costs == []
    (cost,) = costs
    assert cost.share >= 0.0
    assert cost.memory_mb > 1.0


def test_a_server_that_does_not_come_up_is_told_of():
    with pytest.raises(BenchError, match="did not come up"), served(ENDS, SERVES, []):
        pytest.fail("nothing is up")


def test_clients_that_end_before_the_drive_are_told_of(tmp_path: Path):
    costs: list[ServerCost] = []
    told = tmp_path / "pid"
    says = f"import os; open('{told}.new', 'w').write(str(os.getpid()))"
    ends = [sys.executable, "-c", f"{says}; os.rename('{told}.new', '{told}')"]
    with pytest.raises(BenchError, match="ended before the drive"), served(SERVES, ends, costs):
        _until_it_has_ended(told)
    assert costs == []


def _until_it_has_ended(told: Path) -> None:
    """The child that leaves its number there; its status is left to who began it."""
    by_s = time.monotonic() + 30.0
    while not told.exists():
        assert time.monotonic() < by_s
        time.sleep(0.01)
    os.waitid(os.P_PID, int(told.read_text()), os.WEXITED | os.WNOWAIT)


def test_what_a_process_has_used_is_its_own_time():
    before_s = time.process_time()
    used_s = cpu_s(os.getpid())
    tick_s = 2.0 / os.sysconf("SC_CLK_TCK")
    assert before_s - tick_s <= used_s <= time.process_time() + tick_s
