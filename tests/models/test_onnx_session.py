"""Opening a network tells nobody of it."""

import os
import subprocess
import sys
from pathlib import Path

from places import ROOT


def test_nothing_is_told_to_the_maker_of_onnx_runtime(tmp_path: Path) -> None:
    """It keeps what it is going to send, and a number of the device, in the user's cache. A process
    of its own, without what a CI sets, under which it is silent."""
    code = (
        "import sys, pathlib; from models.onnx_session import open_session; "
        "open_session(pathlib.Path(sys.argv[1]))"
    )
    network = ROOT / "models" / "weights" / "nanodet-g.onnx"
    home = str(tmp_path)
    kept = {name: os.environ[name] for name in ("PATH", "PYTHONPATH") if name in os.environ}
    subprocess.run(
        [sys.executable, "-c", code, network], cwd=ROOT, check=True, capture_output=True,
        env={**kept, "HOME": home, "XDG_CACHE_HOME": home},
    )  # fmt: skip
    assert list(tmp_path.rglob("*")) == []
