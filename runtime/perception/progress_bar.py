"""How far a download is, on a terminal."""

from typing import Any

from tqdm import tqdm


class Bar:
    """A tqdm bar (on a terminal only) that follows the store's progress reports."""

    def __init__(self) -> None:
        self._bar: Any = None
        self._what = ""

    def __enter__(self) -> "Bar":
        return self

    def __exit__(self, *_: object) -> None:
        self._close()

    def __call__(self, what: str, done: int, total: int) -> None:
        if what != self._what:
            self._close()
            self._bar = tqdm(desc=what, unit="B", unit_scale=True, disable=None, leave=False)
            self._what = what
        self._bar.total = max(total, done) or None
        self._bar.update(done - self._bar.n)

    def _close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar, self._what = None, ""
