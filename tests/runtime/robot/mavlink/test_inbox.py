"""Bytes that come over a link, as messages."""

from mavlink_messages import GUIDED, heartbeat, packed

from runtime.robot.mavlink.inbox import Inbox

HEARTBEAT = bytes(heartbeat(mode=GUIDED).get_msgbuf())


def kinds(messages) -> list[str]:
    return [message.get_type() for message in messages]


def test_a_stream_may_break_anywhere_and_a_datagram_is_read_on_its_own():
    inbox = Inbox()
    assert inbox.read(HEARTBEAT[:7], datagram=False) == []
    assert kinds(inbox.read(HEARTBEAT[7:] + HEARTBEAT, datagram=False)) == ["HEARTBEAT"] * 2
    assert inbox.read(HEARTBEAT[:7], datagram=True) == []
    assert kinds(inbox.read(HEARTBEAT, datagram=True)) == ["HEARTBEAT"]
    assert inbox.bad == 0


def test_what_cannot_be_read_is_counted_and_dropped():
    inbox = Inbox()
    spoilt = bytearray(packed(heartbeat()))
    spoilt[-1] ^= 0xFF
    assert inbox.read(bytes(spoilt), datagram=True) == []
    assert inbox.bad == 1
    assert kinds(inbox.read(b"\x00\x01" + HEARTBEAT, datagram=True)) == ["HEARTBEAT"]
    assert inbox.bad > 1


def test_what_comes_after_a_link_was_opened_anew_is_another_stream():
    inbox = Inbox()
    inbox.read(HEARTBEAT[:7], datagram=False)
    inbox.clear()
    assert kinds(inbox.read(HEARTBEAT, datagram=False)) == ["HEARTBEAT"]
    assert inbox.bad == 0
