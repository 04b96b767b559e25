"""What cloud calls cost, kept where a restart finds it: caps per goal and per day.

Before a call its worst case is reserved, in one transaction with the check of both caps; after it,
what the reply says was used takes the reservation's place. A process that dies in between leaves
its reservation booked. Amounts are whole nano-dollars, rounded up.
"""

import math
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from runtime.private_files import state_directory, tighten

NANO = 1_000_000_000
RESUMED_S = 12 * 3600
"""A goal that was under way when the runtime ended is the same goal when it is given again so soon
after; its account goes on."""

_TABLES = """
CREATE TABLE IF NOT EXISTS account (
    id INTEGER PRIMARY KEY, goal TEXT NOT NULL, touched_s REAL NOT NULL, ended INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS booking (
    id INTEGER PRIMARY KEY, account INTEGER NOT NULL, day TEXT NOT NULL, what TEXT NOT NULL,
    reserved_nano INTEGER NOT NULL, settled_nano INTEGER);
CREATE INDEX IF NOT EXISTS booking_day ON booking (day);
CREATE INDEX IF NOT EXISTS booking_account ON booking (account);
"""
_SUM = "SELECT COALESCE(SUM(COALESCE(settled_nano, reserved_nano)), 0) FROM booking WHERE "


class SpendingError(Exception):
    """The file of what was spent cannot be used: nothing may be spent."""


class CapReached(Exception):
    """The call could cost more than a cap leaves."""


@dataclass(frozen=True)
class Caps:
    """US dollars."""

    goal_usd: float
    day_usd: float


@dataclass(frozen=True)
class Prices:
    """US dollars per million tokens."""

    in_usd: float
    out_usd: float

    def nano(self, tokens_in: int, tokens_out: int) -> int:
        """What so many tokens cost, in nano-dollars, rounded up."""
        micro = tokens_in * self.in_usd + tokens_out * self.out_usd  # USD per million: micro-USD
        return math.ceil(round(micro * 1000, 6))


def default_path() -> Path:
    """`spending.sqlite` in RF-NAV's state, which is not a cache: it must not be cleaned away."""
    return state_directory() / "spending.sqlite"


def _now() -> datetime:
    return datetime.now(UTC)


class Spending:
    """The ledger. Several threads and processes may share its file. `now` gives the UTC time; a
    day is one of UTC. Every method raises SpendingError when the file cannot be used."""

    def __init__(self, path: Path, caps: Caps, now: Callable[[], datetime] = _now) -> None:
        self._path, self._caps, self._now = path, caps, now
        self._account, self._limit_usd = 0, math.inf

    def afford(self, usd: float) -> None:
        """The goal under way has a limit of its own beside the cap."""
        self._limit_usd = usd

    def begin(self, goal: str) -> None:
        """What is spent from now on is for this goal; one that a restart cut off goes on."""
        now_s = self._now().timestamp()
        with self._transaction() as file:
            if self._account:
                file.execute("UPDATE account SET ended = 1 WHERE id = ?", (self._account,))
            found = file.execute(
                "SELECT id FROM account WHERE goal = ? AND ended = 0 AND touched_s >= ?"
                " ORDER BY id DESC",
                (goal, now_s - RESUMED_S),
            ).fetchone()
            if found is None:
                found = file.execute(
                    "INSERT INTO account (goal, touched_s, ended) VALUES (?, ?, 0) RETURNING id",
                    (goal, now_s),
                ).fetchone()
            self._account = _whole(found)

    def finish(self) -> None:
        """The goal is done with: given again, it is another one."""
        if not self._account:
            return
        with self._transaction() as file:
            file.execute("UPDATE account SET ended = 1 WHERE id = ?", (self._account,))
        self._account = 0

    def reserve(self, nano: int, what: str) -> int:
        """Book the worst case of a call; returns the booking. Raises CapReached."""
        now = self._now()
        day = now.strftime("%Y-%m-%d")
        with self._transaction() as file:
            spent_day = self._sum(file, "day = ?", day)
            spent_goal = self._sum(file, "account = ?", self._account)
            for name, spent, cap in (
                ("goal", spent_goal, min(self._caps.goal_usd, self._limit_usd)),
                ("day", spent_day, self._caps.day_usd),
            ):
                if spent + nano > round(cap * NANO):
                    left = max(0.0, cap - spent / NANO)
                    raise CapReached(
                        f"cap per {name}: {left:.6f} of {cap:g} USD left, "
                        f"a call may cost {nano / NANO:.6f}"
                    )
            file.execute(
                "UPDATE account SET touched_s = ? WHERE id = ?", (now.timestamp(), self._account)
            )
            row = file.execute(
                "INSERT INTO booking (account, day, what, reserved_nano) VALUES (?, ?, ?, ?)"
                " RETURNING id",
                (self._account, day, what, nano),
            ).fetchone()
            return _whole(row)

    def settle(self, booking: int, nano: int | None) -> int:
        """Replace a reservation by what the call cost; None lets it stand. Returns what is
        booked."""
        # Not waiting for the disk: if the power fails, the reservation, which is more, stands.
        with self._transaction(durable=False) as file:
            row = file.execute(
                "UPDATE booking SET settled_nano = COALESCE(?, reserved_nano) WHERE id = ?"
                " RETURNING settled_nano",
                (nano, booking),
            ).fetchone()
            return _whole(row)

    def spent(self) -> tuple[float, float]:
        """US dollars booked for this goal and on this day."""
        day = self._now().strftime("%Y-%m-%d")
        with self._transaction(durable=False) as file:
            goal = self._sum(file, "account = ?", self._account) if self._account else 0
            return goal / NANO, self._sum(file, "day = ?", day) / NANO

    @staticmethod
    def _sum(file: sqlite3.Connection, where: str, value: object) -> int:
        return _whole(file.execute(_SUM + where, (value,)).fetchone())

    @contextmanager
    def _transaction(self, durable: bool = True) -> Iterator[sqlite3.Connection]:
        """One at a time over all processes; when it is `durable`, on disk when it ends."""
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            tighten(self._path)
            with closing(sqlite3.connect(self._path, timeout=10.0, isolation_level=None)) as file:
                file.execute("PRAGMA journal_mode=WAL")
                file.execute(f"PRAGMA synchronous={'FULL' if durable else 'NORMAL'}")
                file.executescript(_TABLES)
                file.execute("BEGIN IMMEDIATE")
                try:
                    yield file
                except BaseException:
                    file.execute("ROLLBACK")
                    raise
                file.execute("COMMIT")
        except (sqlite3.Error, OSError, UnicodeDecodeError) as error:  # of SQLite's own words, too
            told = " ".join(str(error).split())
            raise SpendingError(
                f"{self._path}: {told}; nothing is spent until it can be used"
            ) from error


def _whole(row: Sequence[object] | None) -> int:
    """The number that a row is. Whoever wrote into the file may have written anything: SQLite's
    columns have no types."""
    value = row[0] if row else None
    if not isinstance(value, int) or value < 0:
        raise sqlite3.DataError(f"has {value!r:.40} in place of a number of its own")
    return value
