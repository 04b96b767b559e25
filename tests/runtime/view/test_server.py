"""The page's server against browsers that are its own, others', hostile, many, slow and dead."""

import http.client
import json
import socket
import struct
import zlib
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live_page import until
from page_client import PageClient
from page_server import HeldFeed, allowed, free_port, page_server
from websockets.exceptions import ConnectionClosed, InvalidStatus

from runtime.view.hub import PAGES_MOST
from runtime.view.tiles import CELLS, SIDE, TileGrid

TOKEN = "0123456789abcdef0123"
PATIENCE_S = 10.0


def fetched(port: int, way: str, method: str = "GET", **headers: str) -> http.client.HTTPResponse:
    wire = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
    wire.request(method, way, headers=headers)
    response = wire.getresponse()
    response.body = response.read()  # type: ignore[attr-defined]
    wire.close()
    return response


def refused(port: int, **how: Any) -> int:
    """The status by which a WebSocket is refused."""
    with pytest.raises(InvalidStatus) as told:
        PageClient(port, **how)
    status: int = told.value.response.status_code
    return status


def sent_away(client: PageClient) -> int:
    """The code with which the server closes."""
    with pytest.raises(ConnectionClosed) as told:
        client.wait("nothing of the kind")
    assert told.value.rcvd is not None
    code: int = told.value.rcvd.code
    return code


# -- what a page is served -----------------------------------------------------------------------


def test_the_page_is_served_with_what_browsers_are_to_keep_to(port: int):
    response = fetched(port, "/")
    assert response.status == 200
    assert b"RF-NAV" in response.body  # type: ignore[attr-defined]
    policy = response.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert response.headers["x-content-type-options"] == "nosniff"
    assert response.headers["server"] is None
    assert response.headers["set-cookie"] is None
    assert fetched(port, "/page.js").headers["content-type"].startswith("text/javascript")


def test_nothing_beside_the_page_is_served(port: int, page: Path):
    (page.parent / "secret.txt").write_text("secret")
    (page / "__init__.py").write_text("secret = 1")
    for way in (
        "/__init__.py",
        "/../secret.txt",
        "/%2e%2e/secret.txt",
        "/..%2fsecret.txt",
        "/etc/passwd",
    ):
        assert fetched(port, way).status == 404


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "robot.local", ""])
def test_a_name_that_was_led_to_our_address_is_refused(port: int, host: str):
    """DNS rebinding: the browser believes that it speaks to the other."""
    assert fetched(port, "/", Host=host).status == 403
    upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
    key = {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Protocol": "rfnav.1"}
    told = fetched(port, "/ws", Host=host, Origin=f"http://{host}", **upgrade, **key)
    assert told.status == 403


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1:1", ""]
)
def test_a_page_of_another_origin_can_do_nothing(port: int, feed: HeldFeed, origin: str):
    told = origin.format(port=port)
    assert refused(port, origin=told) == 403
    assert fetched(port, "/stop", "POST", Origin=told).status == 403
    assert feed.asked == []


def test_who_says_no_origin_may_not_stop_it(port: int, feed: HeldFeed):
    assert fetched(port, "/stop", "POST").status == 403
    assert feed.asked == []


def test_stop_has_a_way_beside_the_websocket(port: int, feed: HeldFeed):
    response = fetched(port, "/stop", "POST", Origin=f"http://127.0.0.1:{port}")
    assert (response.status, feed.asked) == (200, [("stop", {})])
    assert fetched(port, "/stop").status == 404
    assert len(feed.asked) == 1


# -- a conversation ------------------------------------------------------------------------------


def test_a_page_is_told_what_is_newest_of_every_kind(port: int, feed: HeldFeed):
    feed.audience.tell("state", {"link": "no service"})
    feed.audience.tell("state", {"link": "ok"})
    with closing(PageClient(port)) as client:
        first = client.next()
        assert isinstance(first, dict)
        assert (first["kind"], first["v"], first["mode"]) == ("welcome", 1, "live")
        assert client.wait("state")["link"] == "ok"
        until(lambda: feed.looking == (1, 0))
    until(lambda: feed.looking == (0, 0))
    assert feed.left == [first["you"]]


def test_the_map_comes_as_tiles_and_then_as_what_changed(port: int, feed: HeldFeed):
    cells = np.zeros((SIDE, 2 * SIDE), np.uint8)
    cells[3, 5] = 1
    cells[3, SIDE] = 2
    with closing(PageClient(port)) as client:
        feed.tiles.put(CELLS, TileGrid(cells, 0.05, -1.0, 2.0))
        feed.audience.mapped()
        head = struct.unpack_from("<BBHIfddH", message := client.binary(1))
        assert head[2] == SIDE
        assert head[4:] == (pytest.approx(0.05), -1.0, 2.0, 2)
        tiles = np.frombuffer(zlib.decompress(message[30 + 16 :]), np.uint8)
        assert tiles.reshape(2, 2, SIDE, SIDE)[0, 0, 3, 5] == 1
        cells[4, SIDE] = 2
        feed.tiles.put(CELLS, TileGrid(cells, 0.05, -1.0, 2.0))
        feed.audience.mapped()
        message = client.binary(1)
        assert struct.unpack_from("<Hii", message, 28) == (1, 1, 0)


def test_images_go_to_those_who_watch_and_only_while_they_do(port: int, feed: HeldFeed):
    with closing(PageClient(port)) as watching, closing(PageClient(port)) as other:
        watching.say(kind="watch", camera=True, hidden=False)
        until(lambda: feed.looking == (2, 1))
        feed.audience.picture(b"\x02picture")
        assert watching.binary(2) == b"\x02picture"
        feed.audience.tell("state", {"link": "ok"})
        other.wait("state")
        watching.say(kind="watch", camera=True, hidden=True)
        until(lambda: feed.looking == (2, 0))
        assert not [m for m in (other.heard,) if 2 in m]


def test_a_page_that_is_shown_again_has_all_that_it_missed(port: int, feed: HeldFeed):
    with closing(PageClient(port)) as client:
        client.wait("welcome")
        client.say(kind="watch", hidden=True)
        client.ask(1, "why")
        feed.audience.tell("scene", {"goal": "mug"})
        feed.audience.tell("stop", {"number": 3})
        client.wait("stop")
        assert "scene" not in client.heard
        assert feed.left == [client.heard["welcome"]["you"]]  # nor does it drive
        client.say(kind="watch", hidden=False)
        assert client.wait("scene")["goal"] == "mug"


def test_what_is_asked_is_answered_with_its_number(port: int, feed: HeldFeed):
    with closing(PageClient(port)) as client:
        assert client.ask(7, "resume")["answer"] == {"asked": "resume"}
        assert client.ask(8, "pause")["error"] == "nobody answers: is rfnav run up?"
        assert client.ask(9, "zones", none=1)["error"] == "zones: must have one of add"
        client.say(kind="teleop", v=0.5, w=0.0)
        until(lambda: feed.steered)
        assert feed.steered[0][1]["v"] == 0.5


def test_a_stop_waits_behind_no_other_question(port: int, feed: HeldFeed):
    feed.slow.clear()
    with closing(PageClient(port)) as client:
        for n in range(40):  # more than are answered at once, and than may wait
            client.say(kind="do", n=n, what="goal", body={"goal": "mug"})
        client.say(kind="do", n=99, what="stop", body={})
        told = [client.wait("done")]
        while told[-1]["n"] != 99:
            told.append(client.wait("done"))
        assert told[-1]["answer"] == {"asked": "stop"}
        assert {one["error"] for one in told[:-1]} == {"too many questions wait"}
        feed.slow.set()


# -- who may -------------------------------------------------------------------------------------


@pytest.mark.parametrize("given", [None, "", "another-token-altogether", 7, ["x"]])
def test_without_the_token_nothing_is_told(feed: HeldFeed, page: Path, given: Any):
    port = free_port()
    with page_server(allowed(port, TOKEN), feed, page):
        feed.audience.tell("state", {"link": "ok"})
        with closing(PageClient(port, token=given)) as client:
            assert sent_away(client) == 4401
            assert client.heard == {}
        origin = f"http://127.0.0.1:{port}"
        assert fetched(port, "/stop", "POST", Origin=origin).status == 401
        assert feed.asked == []


def test_with_the_token_all_is(feed: HeldFeed, page: Path):
    port = free_port()
    with page_server(allowed(port, TOKEN), feed, page):
        with closing(PageClient(port, token=TOKEN)) as client:
            client.wait("welcome")
        bearer = {"Origin": f"http://127.0.0.1:{port}", "Authorization": f"Bearer {TOKEN}"}
        assert fetched(port, "/stop", "POST", **bearer).status == 200


@pytest.mark.parametrize(
    "hello", [{"kind": "do"}, {"kind": "hello", "v": 2}, {"kind": "hello"}, {"x": 1}]
)
def test_who_does_not_say_hello_is_sent_away(port: int, hello: dict[str, Any]):
    with closing(PageClient(port, hello=hello)) as client:
        assert sent_away(client) == 4400


@pytest.mark.parametrize(
    "said", ["[]", "nonsense", "{" * 200, '{"kind": "do", "n": "x", "what": 1}', b"\x00", "NaN"]
)
def test_nonsense_is_the_end_of_a_conversation_and_of_nothing_else(
    port: int, feed: HeldFeed, said: str | bytes
):
    with closing(PageClient(port)) as client, closing(PageClient(port)) as other:
        client.wait("welcome")
        client.say_raw(said)
        assert sent_away(client) == 4400
        assert other.ask(1, "why")["answer"] == {"asked": "why"}


def test_a_huge_message_is_not_taken(port: int, feed: HeldFeed):
    with closing(PageClient(port)) as client:
        client.wait("welcome")
        client.say(kind="do", n=1, what="goal", body={"goal": "x" * 20_000})
        assert sent_away(client) == 1009
    assert feed.asked == []


def test_a_flood_is_the_end_of_its_conversation(port: int, feed: HeldFeed):
    with closing(PageClient(port)) as client:
        client.wait("welcome")
        with suppress(ConnectionClosed):
            for _ in range(2000):
                client.say(kind="teleop", v=1, w=0)
        assert sent_away(client) == 4429
        assert len(feed.steered) < 200


def test_more_pages_than_there_is_room_for_are_sent_away(port: int, feed: HeldFeed):
    clients = [PageClient(port) for _ in range(PAGES_MOST)]
    for client in clients:
        client.wait("welcome")
    with closing(PageClient(port)) as late:
        assert sent_away(late) == 4429
    clients[0].close()
    until(lambda: feed.looking[0] == PAGES_MOST - 1)
    with closing(PageClient(port)) as again:
        again.wait("welcome")
    for client in clients[1:]:
        client.close()


# -- slow and dead ones --------------------------------------------------------------------------


def test_a_page_that_reads_nothing_holds_up_nobody_and_gets_the_newest(port: int, feed: HeldFeed):
    """What waits for it is one message of each kind, beside what the wires hold."""
    with closing(PageClient(port)) as slow, closing(PageClient(port)) as quick:
        slow.wait("welcome")
        quick.wait("welcome")
        slow.say(kind="watch", camera=True)
        until(lambda: feed.looking == (2, 1))
        for n in range(400):
            feed.audience.tell("scene", {"n": n, "much": "x" * 60_000})
            feed.audience.picture(bytes([2]) + bytes(60_000))
            assert quick.wait("scene", n=n)["n"] == n
        scenes = []
        while not scenes or scenes[-1] < 399:
            told = slow.next()
            scenes += [told["n"]] if isinstance(told, dict) else []
        assert len(scenes) < 200
        assert scenes == sorted(scenes)


def test_a_client_that_dies_without_a_word_is_forgotten(port: int, feed: HeldFeed):
    client = PageClient(port)
    client.wait("welcome")
    wire = client.socket.socket
    wire.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    wire.shutdown(socket.SHUT_RDWR)
    wire.close()
    until(lambda: feed.looking == (0, 0))


def test_half_a_request_holds_up_nobody(port: int):
    with socket.create_connection(("127.0.0.1", port)) as wire:
        wire.sendall(b"GET / HTTP/1.1\r\nHost: ")
        assert fetched(port, "/").status == 200


def test_json_that_was_told_is_what_a_page_gets(port: int, feed: HeldFeed):
    feed.audience.tell("zones", {"zones": [{"name": "Küche", "polygon": [[0, 1.5]]}]})
    with closing(PageClient(port)) as client:
        told = client.wait("zones")
        assert json.dumps(told["zones"]) == json.dumps([{"name": "Küche", "polygon": [[0, 1.5]]}])
