"""Lines on standard error, and entries of systemd's journal where that reads it."""

import os
import socket
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from runtime import log
from runtime.log import DEBUG, FIELD_BYTES, MESSAGE_BYTES, WARNING, say


@pytest.fixture
def journal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[socket.socket]:
    """Stands in for systemd's, which reads our standard error: a file."""
    path = tmp_path / "socket"
    with (
        socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard,
        (tmp_path / "stderr").open("w+", encoding="utf-8") as stderr,
    ):
        heard.bind(str(path))
        heard.settimeout(0.0)
        there = os.fstat(stderr.fileno())
        monkeypatch.setattr(log, "sys", SimpleNamespace(stderr=stderr))  # pytest has its own
        monkeypatch.setattr(log, "JOURNAL", path)
        monkeypatch.setenv("JOURNAL_STREAM", f"{there.st_dev}:{there.st_ino}")
        yield heard


def lines() -> str:
    return Path(log.sys.stderr.name).read_text(encoding="utf-8")


def test_without_systemd_it_is_a_line_whatever_its_fields(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.delenv("JOURNAL_STREAM", raising=False)
    say("ready", WARNING, EVENT="standing")
    say("decision 3", DEBUG, EVENT="decision")  # of which there are many
    assert capsys.readouterr().err == "rfnav: ready\n"


def test_under_systemd_it_is_an_entry_with_fields_and_no_line(journal: socket.socket):
    say("searching -> held", WARNING, EVENT="halt", STATE="held")
    assert journal.recv(65536).split(b"\n") == [
        b"MESSAGE=searching -> held", b"PRIORITY=4", b"SYSLOG_IDENTIFIER=rfnav",
        b"RFNAV_EVENT=halt", b"RFNAV_STATE=held", b"",
    ]  # fmt: skip
    say("decision 3", DEBUG)
    assert journal.recv(65536).startswith(b"MESSAGE=decision 3\nPRIORITY=7\n")
    assert lines() == ""


def test_what_has_line_breaks_goes_with_its_length(journal: socket.socket):
    say("two\nlines\nRFNAV_STATE=forged", STATE="a\nPRIORITY=0")
    said = b"two\nlines\nRFNAV_STATE=forged"
    assert journal.recv(65536) == (
        b"MESSAGE\n" + len(said).to_bytes(8, "little") + said + b"\nPRIORITY=6\n"
        b"SYSLOG_IDENTIFIER=rfnav\nRFNAV_STATE\n" + (12).to_bytes(8, "little") + b"a\nPRIORITY=0\n"
    )


def test_what_is_too_long_for_a_datagram_is_cut(journal: socket.socket):
    say("x" * 10 * MESSAGE_BYTES, CAUSE="y" * 10 * FIELD_BYTES)
    entry = journal.recv(1 << 20)
    assert entry.startswith(b"MESSAGE=" + b"x" * MESSAGE_BYTES + b"\n")
    assert entry.endswith(b"\nRFNAV_CAUSE=" + b"y" * FIELD_BYTES + b"\n")


def test_letters_that_are_none_do_not_end_anything(journal: socket.socket):
    say("half a letter: \ud800")
    assert journal.recv(65536).startswith(b"MESSAGE=half a letter: ?\n")


def test_a_journal_that_does_not_take_it_gets_it_as_a_line(journal: socket.socket):
    Path(log.JOURNAL).unlink()
    say("ready", EVENT="standing")
    assert lines() == "rfnav: ready\n"


def test_a_journal_that_is_full_is_not_waited_for(journal: socket.socket):
    for n in range(3000):
        say(f"line {n}")
    assert lines().endswith("rfnav: line 2999\n")


@pytest.mark.parametrize("stream", ["", "1", "1:2", "x:y"])
def test_where_standard_error_was_led_elsewhere_it_is_a_line(
    journal: socket.socket, stream: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("JOURNAL_STREAM", stream)
    say("ready")
    assert lines() == "rfnav: ready\n"


def test_without_standard_error_nothing_ends(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("JOURNAL_STREAM", "1:2")
    monkeypatch.setattr(log, "sys", SimpleNamespace(stderr=None))
    say("ready")
