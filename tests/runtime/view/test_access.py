"""Who may look: nothing is open beyond this computer without a certificate and a token."""

from dataclasses import replace
from pathlib import Path

import pytest

from runtime.errors import ConfigError
from runtime.view.access import CSP, access

TOKEN = "0123456789abcdef"


@pytest.fixture
def token_file(tmp_path: Path) -> Path:
    path = tmp_path / "token"
    path.write_text(f"{TOKEN}\n")
    path.chmod(0o600)
    return path


def test_on_this_computer_nothing_is_asked_for():
    one = access("127.0.0.1:8080", None, None, None)
    assert (one.scheme, one.host, one.port, one.token) == ("http", "127.0.0.1", 8080, "")
    assert one.host_allowed("127.0.0.1:8080")
    assert one.host_allowed("LOCALHOST:8080")
    assert one.host_allowed("[::1]:8080")
    assert not one.host_allowed("127.0.0.1")
    assert not one.host_allowed("127.0.0.1:8081")
    assert not one.host_allowed("evil.example:8080")
    assert not one.host_allowed("")
    assert one.token_right(None)
    assert not replace(one, token="sesame" * 3).token_right("\ud800" * 18)


@pytest.mark.parametrize("listen", ["0.0.0.0:8080", "192.168.1.20:8080", "[::]:8080", "robot:80"])
def test_beyond_it_a_certificate_and_a_token_are(
    listen: str, pair: tuple[Path, Path], token_file: Path
):
    with pytest.raises(ConfigError, match="beyond this computer all could"):
        access(listen, None, None, None)
    with pytest.raises(ConfigError, match="beyond this computer"):
        access(listen, *pair, None)
    with pytest.raises(ConfigError, match="beyond this computer"):
        access(listen, None, None, token_file)
    assert access(listen, *pair, token_file).scheme == "https"


def test_a_page_is_ours_by_scheme_name_and_port(pair: tuple[Path, Path], token_file: Path):
    one = access("0.0.0.0:8443", *pair, token_file, ["robot.local"])
    assert one.origin_allowed("https://robot.local:8443", "robot.local:8443")
    assert not one.origin_allowed("http://robot.local:8443", "robot.local:8443")
    assert not one.origin_allowed("https://robot.local", "robot.local:8443")
    assert not one.origin_allowed("https://localhost:8443", "robot.local:8443")
    assert not one.origin_allowed("https://evil.example:8443", "evil.example:8443")
    assert not one.origin_allowed("", "robot.local:8443")


def test_the_usual_port_need_not_be_named(pair: tuple[Path, Path], token_file: Path):
    one = access("0.0.0.0:443", *pair, token_file, ["robot.local"])
    assert one.origin_allowed("https://robot.local", "robot.local")


def test_the_token_is_compared_whole(token_file: Path):
    one = access("127.0.0.1:8080", None, None, token_file)
    assert one.token_right(TOKEN)
    for wrong in (None, "", TOKEN[:-1], f"{TOKEN}0", 7, {}, "ä" * 16):
        assert not one.token_right(wrong)


@pytest.mark.parametrize("listen", ["8080", "127.0.0.1", "127.0.0.1:0", "127.0.0.1:x", ":8080",
                                    "127.0.0.1:70000", ""])  # fmt: skip
def test_an_address_that_is_none_is_told(listen: str):
    with pytest.raises(ConfigError, match="is no address"):
        access(listen, None, None, None)


@pytest.mark.parametrize("text", ["short", "x" * 600, "with a space in it", "", "é" * 20])
def test_a_token_that_could_be_guessed_or_not_sent_is_refused(token_file: Path, text: str):
    token_file.write_text(text, encoding="latin-1")
    with pytest.raises(ConfigError, match="--token-file"):
        access("127.0.0.1:8080", None, None, token_file)


def test_a_token_or_key_that_others_can_read_is_refused(
    token_file: Path, pair: tuple[Path, Path], tmp_path: Path
):
    token_file.chmod(0o644)
    with pytest.raises(ConfigError, match="chmod 600"):
        access("127.0.0.1:8080", None, None, token_file)
    key = tmp_path / "key.pem"
    key.write_bytes(pair[1].read_bytes())
    key.chmod(0o644)
    with pytest.raises(ConfigError, match="chmod 600"):
        access("127.0.0.1:8080", pair[0], key, None)


def test_certificates_that_cannot_be_used_are_told_at_once(pair: tuple[Path, Path], tmp_path: Path):
    with pytest.raises(ConfigError, match="go together"):
        access("127.0.0.1:8080", pair[0], None, None)
    with pytest.raises(ConfigError, match="does not go with"):
        access("127.0.0.1:8080", pair[1], pair[1], None)
    with pytest.raises(ConfigError, match="No such file"):
        access("127.0.0.1:8080", tmp_path / "none", pair[1], None)
    with pytest.raises(ConfigError, match="No such file"):
        access("127.0.0.1:8080", None, None, tmp_path / "none")


def test_nothing_from_elsewhere_may_run_or_frame_the_page():
    assert "default-src 'none'" in CSP
    assert "frame-ancestors 'none'" in CSP
    assert "unsafe" not in CSP
    assert "http" not in CSP
