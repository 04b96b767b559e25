"""Scores that outlive the process: a home's words are the same tomorrow."""

import math
import os
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Final

from runtime.core.voting.likelihood_experts import LikelihoodQuestion
from runtime.private_files import tighten

_TABLE = """CREATE TABLE IF NOT EXISTS score (
    model TEXT, context TEXT, continuation TEXT, value REAL,
    PRIMARY KEY (model, context, continuation)) WITHOUT ROWID"""

# What of a damaged schema is no text is none in SQLite's own words of it either.
DAMAGED: Final = (sqlite3.Error, OSError, UnicodeDecodeError)


def default_path() -> Path:
    """`scores.sqlite` in RF-NAV's cache."""
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache) / "rf-nav" / "scores.sqlite"


class ScoreFile:
    """One model's scores in an SQLite file, which several processes and models may share.

    `model` must change with whatever changes its scores. A file that cannot be used is not:
    `load` returns nothing, and `error` says why.
    """

    def __init__(self, path: Path, model: str) -> None:
        self._path, self._model = path, model
        self.error = ""

    def load(self) -> dict[LikelihoodQuestion, float]:
        """All of them."""
        query = "SELECT context, continuation, value FROM score WHERE model = ?"
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            with self._transaction() as file:
                file.execute(_TABLE)
                rows = file.execute(query, (self._model,)).fetchall()
        except DAMAGED as error:
            self.error = f"{self._path}: {_line(error)}; remove it to begin anew"
            return {}
        # Whoever wrote into it may have written anything: SQLite's columns have no types.
        return {
            LikelihoodQuestion(context, text): value
            for context, text, value in rows
            if isinstance(context, str) and isinstance(text, str) and isinstance(value, float)
            and math.isfinite(value)
        }  # fmt: skip

    def keep(self, scores: Iterable[tuple[LikelihoodQuestion, float]]) -> None:
        """Add scores. After an error nothing more is written."""
        if self.error:
            return
        rows = [(self._model, q.context, q.continuation, value) for q, value in scores]
        try:
            with self._transaction() as file:
                file.executemany("INSERT OR REPLACE INTO score VALUES (?, ?, ?, ?)", rows)
        except DAMAGED as error:
            self.error = f"{self._path}: {_line(error)}"

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        """The file, which is closed whatever comes: one that stays open keeps its locks."""
        tighten(self._path)
        with closing(sqlite3.connect(self._path, timeout=10.0)) as file:
            file.execute("PRAGMA journal_mode=WAL")
            file.execute("PRAGMA synchronous=NORMAL")
            with file:
                yield file


def _line(error: Exception) -> str:
    """SQLite tells of a damaged schema in its own lines."""
    return " ".join(str(error).split())
