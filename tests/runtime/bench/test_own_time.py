"""What a thread is at work on is counted by its own time."""

import pytest

from runtime.bench.own_time import TURNS, own_ms, print_stages


def test_work_is_done_as_often_as_is_asked():
    done: list[int] = []
    p50, p90 = own_ms(lambda: done.append(1), turns=7)
    assert len(done) == 7
    assert 0.0 <= p50 <= p90


def test_each_stage_has_a_line(capsys: pytest.CaptureFixture[str]):
    done: list[str] = []
    print_stages([("one", lambda: done.append("one")), ("other", lambda: done.append("other"))])
    assert done == ["one"] * TURNS + ["other"] * TURNS
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["one", "other"]
    assert all(line.endswith(" ms") for line in lines)
