"""Who may ask over HTTP: this computer alone, no browser's page, and with the token where there is
one."""

import http.client
import json
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from agent_client import PATIENCE_S, Served, facts
from agent_service import AgentService

from runtime.agents.http import BODY_BYTES, agent_access
from runtime.agents.tools import AgentLimits
from runtime.errors import ConfigError
from runtime.view.listening import TimedHttp

TOKEN = "0123456789abcdef0123"
PING = {"jsonrpc": "2.0", "id": 1, "method": "ping"}


@pytest.fixture(scope="module")
def service() -> Iterator[AgentService]:
    with AgentService().up() as service:
        yield service


@pytest.fixture(scope="module")
def served(service: AgentService) -> Iterator[Served]:
    with Served(service, AgentLimits(), TOKEN).up() as served:
        yield served


def posted(served: Served, body: bytes, **headers: str) -> int:
    wire = http.client.HTTPConnection("127.0.0.1", served.port, timeout=PATIENCE_S)
    usual = {
        "Authorization": f"Bearer {TOKEN}",
        "Content-Type": "application/json",
        "Accept": "application/json, text/event-stream",
        "Mcp-Protocol-Version": "2025-06-18",
    }
    wire.request("POST", "/mcp", body, usual | {k.replace("_", "-"): v for k, v in headers.items()})
    status = wire.getresponse().status
    wire.close()
    return status


def initialize() -> bytes:
    info = {"name": "test", "version": "1"}
    params = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": info}
    asked = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": params}
    return json.dumps(asked).encode()


def test_a_client_with_the_token_is_served(served: Served):
    told = served.run(lambda client: client.call_tool("status", {}))
    assert facts(told)["state"] == "ready"
    assert posted(served, initialize()) == 200


@pytest.mark.parametrize(
    "given", ["Bearer another-token-of-20-x", "", "Basic x", f"Bearer {TOKEN}x"]
)
def test_another_token_is_refused(served: Served, given: str):
    assert posted(served, initialize(), Authorization=given) == 401


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:1", "https://localhost", ""]
)
def test_no_page_of_a_browser_may_ask(served: Served, origin: str):
    assert posted(served, initialize(), Origin=origin) == 403


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", ""])
def test_a_name_that_was_led_to_our_address_is_refused(served: Served, host: str):
    assert posted(served, initialize(), Host=host) == 403


def test_what_a_form_of_a_page_can_send_is_refused(served: Served):
    assert posted(served, initialize(), Content_Type="text/plain") == 400


def test_bodies_are_bounded(served: Served):
    thing = {"name": "find_object", "arguments": {"thing": "m" * BODY_BYTES}}
    call = {"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": thing}
    assert posted(served, json.dumps(call).encode()) == 413
    assert posted(served, b"[" * 50_000) == 400
    assert posted(served, initialize()) == 200


def test_who_says_nothing_is_let_go(served: Served, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(TimedHttp, "asked_s", 0.05)
    with socket.create_connection(("127.0.0.1", served.port), PATIENCE_S) as wire:
        assert wire.recv(1) == b""


def test_only_this_computer_is_listened_on():
    with pytest.raises(ConfigError, match="is not this computer"):
        agent_access("0.0.0.0:8090", None)
    with pytest.raises(ConfigError, match="is not this computer"):
        agent_access("192.168.1.20:8090", None)
    with pytest.raises(ConfigError, match="is no address"):
        agent_access("8090", None)
    assert agent_access("[::1]:8090", None).host == "::1"


def test_a_token_that_others_can_read_is_refused(tmp_path: Path):
    file = tmp_path / "token"
    file.write_text(TOKEN)
    file.chmod(0o644)
    with pytest.raises(ConfigError, match="chmod 600"):
        agent_access("127.0.0.1:8090", file)
    file.chmod(0o600)
    assert agent_access("127.0.0.1:8090", file).token == TOKEN
