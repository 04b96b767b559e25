"""Slow work is done beside the loop, and its result waits."""

import threading

import pytest

from runtime.loops.errands import Errands

WAIT_S = 20.0


def result(errands: Errands, name: str) -> object:
    waited = threading.Event()
    for _ in range(2000):
        told = errands.take(name)
        if told is not None:
            return told
        waited.wait(0.01)
    raise AssertionError("nothing came")


def test_work_is_done_and_its_result_taken_once():
    errands = Errands(0)
    assert not errands.busy("a")
    errands.ask("a", lambda: 3)
    assert errands.busy("a")
    assert result(errands, "a") == 3
    assert errands.take("a") is None
    assert not errands.busy("a")
    errands.close()


def test_what_waits_is_replaced_and_so_is_its_result():
    errands, begun, go = Errands(0), threading.Event(), threading.Event()
    done = []

    def slow() -> str:
        begun.set()
        assert go.wait(WAIT_S)
        return "first"

    errands.ask("a", slow)
    assert begun.wait(WAIT_S)
    errands.ask("b", lambda: done.append("old"))
    errands.ask("b", lambda: done.append("new") or "b")
    errands.ask("a", lambda: "second")
    go.set()
    assert result(errands, "b") == "b"
    assert result(errands, "a") == "second"
    assert done == ["new"]
    errands.close()


def test_at_the_end_all_that_waits_is_done():
    errands, go, done = Errands(0), threading.Event(), []
    errands.ask("a", lambda: go.wait(WAIT_S))
    errands.ask("b", lambda: done.append("b"))
    go.set()
    errands.close()
    assert done == ["b"]


def test_what_goes_wrong_is_raised_where_results_are_taken():
    errands = Errands(0)
    errands.ask("a", lambda: 1 / 0)
    errands.close()
    with pytest.raises(ZeroDivisionError):
        errands.take("b")
