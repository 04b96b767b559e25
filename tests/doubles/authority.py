"""Certificates for tests, made by the script that people use."""

import subprocess
from pathlib import Path

from places import ROOT

from runtime.robot.endpoints import TlsConfig


def certified(directory: Path, name: str, *hosts: str) -> TlsConfig:
    """What the authority in `directory`, made with the first, gives a machine of that name."""
    script = ROOT / "scripts" / "certificates"
    subprocess.run([script, directory, name, *hosts], check=True, capture_output=True)
    files = (directory / f for f in ("ca.pem", f"{name}.pem", f"{name}-key.pem"))
    return TlsConfig(*map(str, files))
