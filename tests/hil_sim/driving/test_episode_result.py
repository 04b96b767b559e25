"""How an episode ended, as data and as the text that result files hold."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hil_sim.driving.episode_result import End, Ended


@pytest.mark.parametrize(
    ("ended", "text", "failed"),
    [
        (Ended(End.STOP), "stop", False),
        (Ended(End.STEPS), "steps", False),
        (Ended(End.FELL), "fell", False),
        (Ended(End.ERROR, "rfnav: camera: fell off"), "error: rfnav: camera: fell off", True),
    ],
)
def test_an_end_is_one_line(ended: Ended, text: str, failed: bool) -> None:
    assert str(ended) == text
    assert f"{ended}" == text
    assert Ended.parsed(text) == ended
    assert ended.failed is failed


@given(st.text())
def test_any_error_is_read_again_as_it_was_written(why: str) -> None:
    assert Ended.parsed(str(Ended(End.ERROR, why))) == Ended(End.ERROR, why)


def test_an_unknown_end_is_an_error() -> None:
    with pytest.raises(ValueError, match="stopped"):
        Ended.parsed("stopped")
