"""scripts/certificates: what it makes, and what it refuses."""

import ssl
import subprocess
from pathlib import Path

from places import ROOT

SCRIPT = ROOT / "scripts" / "certificates"


def run(*arguments: object) -> tuple[int, str]:
    done = subprocess.run([SCRIPT, *map(str, arguments)], capture_output=True, text=True)
    return done.returncode, done.stderr


def text_of(path: Path) -> str:
    command = ["openssl", "x509", "-in", path, "-noout", "-text"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_each_machine_has_a_certificate_of_one_authority_and_all_of_it_is_the_owners(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "ca"
    status, said = run(folder, "robot", "192.168.1.20", "robot.local", "fe80::1")
    assert (status, said.count("\n")) == (0, 1)
    authority = (folder / "ca.pem").read_bytes()
    assert run(folder, "laptop", "localhost")[0] == 0
    assert (folder / "ca.pem").read_bytes() == authority
    names = {f"{name}{what}.pem" for name in ("ca", "robot", "laptop") for what in ("", "-key")}
    assert {p.name: p.stat().st_mode & 0o777 for p in folder.iterdir()} == dict.fromkeys(
        names, 0o600
    )
    assert folder.stat().st_mode & 0o777 == 0o700
    told = text_of(folder / "robot.pem")
    for part in ("IP Address:192.168.1.20", "DNS:robot.local", "CA:FALSE", "CN = robot",
                 "TLS Web Server Authentication, TLS Web Client Authentication"):  # fmt: skip
        assert part in told
    assert "CA:TRUE, pathlen:0" in text_of(folder / "ca.pem")
    for name in ("robot", "laptop"):
        context = ssl.create_default_context(cafile=str(folder / "ca.pem"))
        context.load_cert_chain(folder / f"{name}.pem", folder / f"{name}-key.pem")
        command = ["openssl", "verify", "-CAfile", folder / "ca.pem", folder / f"{name}.pem"]
        subprocess.run(command, check=True, capture_output=True)


def test_what_it_refuses_changes_nothing(tmp_path: Path) -> None:
    folder = tmp_path / "ca"
    assert run(folder, "robot", "localhost")[0] == 0
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    for arguments, told in (
        ((folder, "robot", "localhost"), "robot.pem is there already"),
        ((folder, "robot"), "say DIR NAME HOST"),
        ((folder, "../robot", "localhost"), "letters, digits"),
        ((folder, "ca", "localhost"), "and not ca"),
        ((folder, "other", "a,DNS:b"), "is no host"),
        ((folder, "other", "999.1.1.1"), "openssl failed"),
    ):
        status, said = run(*arguments)
        assert status == 2, arguments
        assert told in said
        assert said.count("\n") == 1
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before
