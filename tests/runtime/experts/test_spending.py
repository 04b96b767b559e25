"""Caps hold, over threads, processes and restarts."""

import multiprocessing
import sqlite3
import threading
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.experts.spending import NANO, CapReached, Caps, Prices, Spending, SpendingError

NOON = datetime(2026, 11, 22, 12, tzinfo=UTC)
CAPS = Caps(goal_usd=0.10, day_usd=0.25)


class Hands:
    """A clock on the wall."""

    def __init__(self) -> None:
        self.now = NOON

    def __call__(self) -> datetime:
        return self.now


def ledger(path: Path, now: Hands | None = None, caps: Caps = CAPS, goal: str = "bed") -> Spending:
    spending = Spending(path / "spending.sqlite", caps, now or Hands())
    spending.begin(goal)
    return spending


def spend(spending: Spending, usd: float) -> None:
    spending.settle(spending.reserve(round(usd * NANO), "o2f"), round(usd * NANO))


def test_a_goal_may_have_a_limit_below_the_cap_and_none_above(tmp_path: Path) -> None:
    spending = ledger(tmp_path)
    spending.afford(0.03)
    spend(spending, 0.02)
    with pytest.raises(CapReached, match=r"cap per goal: 0\.010000 of 0\.03 USD left"):
        spending.reserve(round(0.02 * NANO), "o2f")
    spending.afford(9.0)
    with pytest.raises(CapReached, match=r"of 0\.1 USD left"):
        spending.reserve(round(0.09 * NANO), "o2f")


def test_a_reservation_counts_until_it_is_settled(tmp_path: Path) -> None:
    spending = ledger(tmp_path)
    booking = spending.reserve(round(0.09 * NANO), "o2f")
    with pytest.raises(CapReached, match=r"cap per goal: 0\.010000 of 0\.1 USD left"):
        spending.reserve(round(0.02 * NANO), "r2f")
    assert spending.settle(booking, round(0.01 * NANO)) == round(0.01 * NANO)
    assert spending.spent() == (0.01, 0.01)
    spend(spending, 0.09)  # the cap itself may be reached
    with pytest.raises(CapReached):
        spending.reserve(1, "r2f")


def test_what_may_have_been_billed_stays_booked(tmp_path: Path) -> None:
    spending = ledger(tmp_path)
    assert spending.settle(spending.reserve(1234, "o2f"), None) == 1234
    assert spending.settle(spending.reserve(500, "o2f"), 0) == 0
    assert spending.spent()[0] == 1234 / NANO


def test_caps_survive_a_restart_in_the_middle_of_a_call(tmp_path: Path) -> None:
    ledger(tmp_path).reserve(round(0.08 * NANO), "o2f")  # and then the process is gone
    again = ledger(tmp_path)
    assert again.spent() == (0.08, 0.08)
    with pytest.raises(CapReached, match="cap per goal"):
        again.reserve(round(0.03 * NANO), "o2f")


def test_each_goal_has_its_own_cap_and_all_share_the_day(tmp_path: Path) -> None:
    now = Hands()
    spending = ledger(tmp_path, now)
    spend(spending, 0.10)
    spending.begin("sofa")
    spend(spending, 0.10)
    spending.begin("bed")  # another search for the same thing: the first one is over
    assert spending.spent()[0] == 0.0
    with pytest.raises(CapReached, match="cap per day"):
        spending.reserve(round(0.06 * NANO), "o2f")
    now.now += timedelta(hours=12)  # midnight
    assert spending.spent() == (0.0, 0.0)
    spend(spending, 0.06)


def test_a_goal_that_ended_is_new_when_it_is_given_again(tmp_path: Path) -> None:
    spending = ledger(tmp_path)
    spend(spending, 0.10)
    spending.finish()
    assert ledger(tmp_path).spent() == (0.0, 0.10)


def test_an_old_goal_is_not_gone_on_with(tmp_path: Path) -> None:
    spend(ledger(tmp_path), 0.10)
    later = Hands()
    later.now += timedelta(hours=13)
    assert ledger(tmp_path, later).spent() == (0.0, 0.0)


def test_a_file_that_cannot_be_used_means_that_nothing_is_spent(tmp_path: Path) -> None:
    bad = tmp_path / "spending.sqlite"
    bad.write_bytes(b"not a database, but long enough to be looked at " * 100)
    with pytest.raises(SpendingError, match=r"spending\.sqlite: file is not a database; nothing"):
        ledger(tmp_path)
    with pytest.raises(SpendingError, match="nothing is spent"):
        Spending(tmp_path / "spending.sqlite" / "below.sqlite", CAPS).reserve(1, "o2f")


def test_damage_that_sqlite_has_no_words_for_is_said_too(tmp_path: Path) -> None:
    ledger(tmp_path)
    file = tmp_path / "spending.sqlite"
    file.write_bytes(file.read_bytes().replace(b"CREATE TABLE", b"CREATE \xbb\xbb\xbb\xbb\xbb"))
    with pytest.raises(SpendingError, match=r"spending\.sqlite: .*; nothing is spent until"):
        ledger(tmp_path)


@pytest.mark.parametrize("number", ["1.5", "'free'", "-5", "x''"])
def test_what_somebody_else_has_written_into_it_is_not_counted_with(
    tmp_path: Path, number: str
) -> None:
    spending = ledger(tmp_path)
    spend(spending, 0.01)
    with closing(sqlite3.connect(tmp_path / "spending.sqlite")) as file, file:
        file.execute(f"UPDATE booking SET settled_nano = {number}")
    with pytest.raises(SpendingError, match=r"in place of a number of its own; nothing is spent"):
        spending.reserve(1, "o2f")


def take(path: Path, tries: int) -> None:
    spending = Spending(path / "spending.sqlite", CAPS, Hands())
    spending.begin("bed")
    for _ in range(tries):
        try:
            spending.reserve(round(0.01 * NANO), "o2f")
        except CapReached:
            return


def test_threads_and_processes_together_stay_under_the_cap(tmp_path: Path) -> None:
    ledger(tmp_path)
    context = multiprocessing.get_context("spawn")
    workers = [context.Process(target=take, args=(tmp_path, 8)) for _ in range(2)]
    workers += [threading.Thread(target=take, args=(tmp_path, 8)) for _ in range(3)]  # type: ignore[list-item]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert ledger(tmp_path).spent() == (0.10, 0.10)


@given(st.integers(0, 10**6), st.integers(0, 10**5), st.floats(0, 1000), st.floats(0, 1000))
def test_no_call_is_booked_below_its_price(tokens_in: int, tokens_out: int, a: float, b: float):
    nano = Prices(a, b).nano(tokens_in, tokens_out)
    exact = (tokens_in * a + tokens_out * b) * 1000
    assert exact - 1e-5 * max(1.0, exact) <= nano <= exact + 1 + 1e-5 * exact


def test_prices_are_per_million_tokens() -> None:
    assert Prices(0.15, 0.60).nano(1_000_000, 0) == round(0.15 * NANO)
    assert Prices(0.15, 0.60).nano(1000, 100) == 150_000 + 60_000
    assert Prices(0.0, 0.0).nano(10**9, 10**9) == 0
