"""`rfnav view` as it is typed."""

import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest
from click.testing import CliRunner
from page_client import PageClient
from page_server import free_port

from runtime.commands import view
from runtime.commands.view import view_command
from runtime.errors import ConfigError

DRIVE = Path(__file__).parents[2] / "refs" / "realtime.mcap"


@contextmanager
def typed(*arguments: str) -> Iterator["subprocess.Popen[str]"]:
    command, pipe = [sys.executable, "-m", "runtime", "view", *arguments], subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def test_a_recording_is_shown_until_ctrl_c():
    port = free_port()
    with typed("--listen", f"127.0.0.1:{port}", "--replay", str(DRIVE)) as process:
        assert process.stdout is not None
        assert f"http://127.0.0.1:{port}/" in process.stdout.readline()
        with closing(PageClient(port)) as page:
            assert page.wait("welcome")["file"] == "realtime.mcap"
            assert page.wait("span")["goals"][0]["goal"] == "toilet"
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=30)
        assert (process.returncode, said) == (0, "")


def test_without_a_service_the_page_is_there_all_the_same():
    port, nobody = free_port(), free_port()
    bus = f'bus.connect=["tcp/127.0.0.1:{nobody}"]'
    with typed("--listen", f"127.0.0.1:{port}", "--set", bus) as process:
        assert process.stdout is not None
        process.stdout.readline()
        with closing(PageClient(port)) as page:
            assert page.wait("state")["link"] == "no service"
            assert "nobody listens" in page.ask(1, "stop")["error"]
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate(timeout=30)
        assert (process.returncode, said) == (0, "")


def test_what_cannot_be_served_is_told_in_a_line():
    with typed("--listen", "0.0.0.0:8080") as process:
        _, said = process.communicate(timeout=60)
    assert process.returncode == 2
    assert "beyond this computer" in said
    assert said.count("\n") == 1


def test_what_is_not_installed_is_told_with_how_to(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(view, "NEEDED", ("json", "no_such_package"))
    result = CliRunner().invoke(view_command, [])
    assert isinstance(result.exception, ConfigError)
    assert "needs no_such_package: pip install 'rf-nav[view]'" in str(result.exception)
