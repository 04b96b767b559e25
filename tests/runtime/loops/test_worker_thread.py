import threading

import pytest

from runtime.loops.worker_thread import WorkerThread

PATIENCE_S = 20.0


def test_what_ends_the_work_is_raised_where_its_results_are_taken():
    def work() -> None:
        raise KeyError("what it was at")

    worker = WorkerThread("worker", work, 0)
    worker.check()
    worker.start()
    worker.close(PATIENCE_S)
    for _ in range(2):  # it does not go away
        with pytest.raises(KeyError, match="what it was at"):
            worker.check()


def test_who_waits_for_the_work_is_told_when_it_ended_in_an_error():
    let_go = threading.Event()

    def work() -> None:
        let_go.wait(PATIENCE_S)
        raise KeyError

    worker = WorkerThread("worker", work, 0)
    worker.start()
    with worker.changed:
        let_go.set()
        assert worker.changed.wait(PATIENCE_S)
    with pytest.raises(KeyError):
        worker.check()


def test_work_that_looks_whether_it_is_closed_ends():
    ended = threading.Event()

    def work() -> None:
        with worker.changed:
            while not worker.closed:
                worker.changed.wait()
        ended.set()

    worker = WorkerThread("worker", work, 0)
    worker.start()
    assert not ended.is_set()
    worker.close(PATIENCE_S)
    assert ended.is_set()
    worker.check()
