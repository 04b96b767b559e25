"""The process that serves a page: what cannot be served is told before anything is."""

import json
import socket
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from page_client import PageClient
from page_server import free_port

from runtime.commands.view_process import ViewOptions, serve_view
from runtime.errors import RfNavError

DRIVE = Path(__file__).parents[2] / "refs" / "realtime.mcap"


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"listen": "0.0.0.0:8080"}, "beyond this computer"),
        ({"listen": "nonsense"}, "is no address"),
        ({"replay": __file__}, "not a recording"),
        ({"settings": ["bus.nosuch=1"]}, "nosuch"),
        ({"config": "/nonexistent.toml"}, "nonexistent"),
        ({"token_file": "/nonexistent"}, "--token-file"),
        ({"certificate": "/nonexistent", "key": "/nonexistent"}, "--certificate"),
    ],
)
def test_options_that_cannot_be_used_are_told_in_a_line(options: dict[str, Any], why: str):
    with pytest.raises(RfNavError, match=why) as told:
        serve_view(ViewOptions(**{"listen": "127.0.0.1:8080", **options}))
    assert "\n" not in str(told.value)


def test_an_address_that_somebody_has_is_told():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        listen = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(RfNavError, match="cannot be listened on"):
            serve_view(ViewOptions(listen, replay=str(DRIVE)))


def test_a_mistake_in_a_thread_ends_the_process_and_is_told():
    """Else its pages would show what was true once."""
    port, nobody = free_port(), free_port()
    spoilt = (
        "from runtime.view.hearing import PageHearing\n"
        "from runtime.commands.view_process import main\n"
        "PageHearing.turn = lambda self: 1 / 0\n"
        "main()"
    )
    bus = [f'bus.connect=["tcp/127.0.0.1:{nobody}"]', "bus.listen=[]"]
    options = json.dumps({"listen": f"127.0.0.1:{port}", "settings": bus})
    process = subprocess.Popen(
        [sys.executable, "-c", spoilt, options],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        assert process.stdout is not None
        process.stdout.readline()
        with closing(PageClient(port)):
            _, said = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 1
    assert "ZeroDivisionError" in said
