"""The process that serves a page: what cannot be served is told before anything is."""

import socket
from pathlib import Path
from typing import Any

import pytest

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
