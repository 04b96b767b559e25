"""A runtime of another checkout, as a process: one that knows less than this harness says."""

import json
from pathlib import Path

import pytest
from places import DOUBLES, ROOT

from hil_sim.driving.other_runtime import OtherRuntime, commit
from runtime.errors import RfNavError

INIT = """
__path__.append({real!r})  # what is not there is this one's
"""
MAIN = """
import json, pathlib, runpy, sys
if "--help" in sys.argv:
    print({help!r})
    sys.exit()
pathlib.Path(__file__).with_name("started.json").write_text(json.dumps(sys.argv[1:]))
sys.argv[1] = "turn"
runpy.run_path({double!r}, run_name="__main__")
"""


@pytest.fixture(params=["--lockstep --harness", "--lockstep"])
def root(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Path, str]:
    """A checkout in which `rfnav run --help` says so much."""
    package = tmp_path / "other" / "runtime"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text(INIT.format(real=str(ROOT / "runtime")))
    double = str(DOUBLES / "fake_runtime.py")
    (package / "__main__.py").write_text(MAIN.format(help=request.param, double=double))
    return package.parent, request.param


def test_it_is_told_what_every_commit_knows(root: tuple[Path, str], tmp_path: Path):
    folder, known = root
    log_dir = tmp_path / "log"
    log_dir.mkdir()
    with OtherRuntime(folder, tmp_path / "other.log", ("camera.z_m=0.5",)) as runtime:
        settings = ["camera.z_m=0.9", 'research.control_mode="velocity"']
        body = {"goal": "toilet", "settings": settings, "log_dir": str(log_dir)}
        assert runtime.ask("goal", body)["accepted"]
    asked = json.loads((log_dir / "asked.json").read_text())
    assert asked["settings"] == ["camera.z_m=0.9"]
    started = json.loads((folder / "runtime" / "started.json").read_text())
    assert started[0] == "run"
    assert ("--harness" in started) is ("--harness" in known)
    assert "camera.z_m=0.5" in started
    assert not any("topics" in argument for argument in started)


def test_a_commit_that_nobody_knows_is_told():
    with pytest.raises(RfNavError, match="nowhere"), commit("nowhere"):
        pass
