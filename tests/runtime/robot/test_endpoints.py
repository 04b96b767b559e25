"""Which endpoints are refused, each in a line that says what would be right."""

from pathlib import Path

import pytest
from authority import certified

from runtime.errors import ConfigError
from runtime.robot.endpoints import TlsConfig, check_endpoint, check_files, is_loopback

GIVEN = TlsConfig("ca.pem", "robot.pem", "robot-key.pem")


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        *((host, True) for host in ("127.0.0.1", "127.8.9.10", "[::1]", "::1", "localhost")),
        *((host, False) for host in ("0.0.0.0", "[::]", "192.168.1.20", "[fe80::1]", "", "*")),
        # a name that is looked up can be anything, whatever it looks like
        *((host, False) for host in ("robot", "localhost.example.com", "127.0.0.1.nip.io")),
        *((host, False) for host in ("[::ffff:192.168.1.20]", "2130706433", "0177.0.0.1")),
    ],
)
def test_loopback_is_an_address_of_this_computer_alone(host: str, loopback: bool) -> None:
    assert is_loopback(host) is loopback


@pytest.mark.parametrize(
    "endpoint",
    [
        *("tcp/127.0.0.1:7447", "tcp/localhost:7447", "tcp/[::1]:7447?prio=6-7", "tcp/127.0.0.1:0"),
        *("tls/0.0.0.0:7447", "tls/robot.local:7447", "tls/[::]:7447#iface=wlan0;so_sndbuf=65000"),
    ],
)
def test_what_strangers_cannot_reach_is_an_endpoint(endpoint: str) -> None:
    check_endpoint("bus.listen", endpoint, GIVEN)


@pytest.mark.parametrize(
    ("endpoint", "tls", "told"),
    [
        ("tcp/0.0.0.0:7447", GIVEN, "is beyond this computer"),
        ("tcp/0.0.0.0:7447", GIVEN, r"use tls/0\.0\.0\.0:7447 with \[bus\.tls\]"),
        ("tcp/[::]:7447", GIVEN, "is beyond this computer"),
        ("tcp/192.168.1.20:7447#iface=lo", GIVEN, "is beyond this computer"),
        ("tcp/robot:7447", GIVEN, "is beyond this computer"),
        *((f"{p}/127.0.0.1:7447", GIVEN, "is no endpoint") for p in ("udp", "ws", "quic", "TCP")),
        *((text, GIVEN, "is no endpoint") for text in ("", "nonsense", "tcp/", "tls/:7447")),
        ("tls/0.0.0.0:7447", TlsConfig(), r"needs bus\.tls\.ca, bus\.tls\.certificate and"),
        ("tls/127.0.0.1:7447", TlsConfig(ca="ca.pem"), r"needs bus\.tls\.ca"),
        *(
            (f"tls/0.0.0.0:7447#{option}", GIVEN, f"sets {option.partition('=')[0]}: ")
            for option in ("enable_mtls=false", "verify_name_on_connect=false")
        ),
        ("tls/0.0.0.0:1#iface=lo; root_ca_certificate_file=x", GIVEN, "sets root_ca_cert"),
    ],
)
def test_what_strangers_could_use_is_refused(endpoint: str, tls: TlsConfig, told: str) -> None:
    with pytest.raises(ConfigError, match=told) as caught:
        check_endpoint("bus.listen", endpoint, tls)
    assert str(caught.value).startswith("bus.listen: ")
    assert "\n" not in str(caught.value)


def test_certificates_that_go_together_can_be_used(tmp_path: Path) -> None:
    check_files(certified(tmp_path, "robot", "127.0.0.1"))


def test_certificates_may_be_credentials(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = certified(tmp_path, "robot", "127.0.0.1")
    folder = Path(made.ca).parent
    monkeypatch.setenv("CREDENTIALS_DIRECTORY", str(folder))
    names = (Path(getattr(made, name)).name for name in ("ca", "certificate", "private_key"))
    tls = TlsConfig(*(f"$CREDENTIALS_DIRECTORY/{name}" for name in names))
    check_files(tls)
    assert tls.named["ca"] == "$CREDENTIALS_DIRECTORY/ca.pem"  # what a guard is told
    monkeypatch.delenv("CREDENTIALS_DIRECTORY")
    with pytest.raises(
        ConfigError, match=r"^bus\.tls\.ca: \$CREDENTIALS_DIRECTORY/ca\.pem: No such"
    ):
        check_files(tls)


def test_what_is_wrong_with_certificates_is_one_line(tmp_path: Path) -> None:
    robot = certified(tmp_path, "robot", "127.0.0.1")
    other = certified(tmp_path, "other", "127.0.0.1")
    text = tmp_path / "text.pem"
    text.write_text("no certificate\n")
    text.chmod(0o600)
    open_key = tmp_path / "open.pem"
    open_key.write_bytes(Path(robot.private_key).read_bytes())
    open_key.chmod(0o644)
    for tls, told in (
        (TlsConfig(robot.ca, "gone.pem", robot.private_key), "certificate: gone.pem: No such file"),
        (TlsConfig(robot.ca, robot.certificate, str(open_key)), "private_key: others can read"),
        (TlsConfig(str(text), robot.certificate, robot.private_key), "ca: .*no certificate in PEM"),
        (TlsConfig(robot.ca, robot.certificate, other.private_key), "certificate: .*does not go"),
        (TlsConfig(robot.ca, robot.certificate, str(text)), "certificate: .*does not go with"),
    ):
        with pytest.raises(ConfigError, match=rf"^bus\.tls\.{told}") as caught:
            check_files(tls)
        assert "\n" not in str(caught.value)
