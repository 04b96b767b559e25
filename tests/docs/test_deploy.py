"""What is deployed starts a robot, and never what a harness may do."""

import os
import shutil
import subprocess
import tomllib

import pytest
from places import ROOT

from hil_sim.driving.link import rfnav_command
from hil_sim.simulation.faults import model_fault, parse_faults

FLAG = "--harness"


def test_nothing_that_is_deployed_has_the_flag():
    files = [path for path in (ROOT / "deploy").rglob("*") if path.is_file()]
    assert files
    for path in files:
        assert FLAG.encode() not in path.read_bytes(), path


def test_the_harness_starts_a_runtime_with_it():
    assert FLAG in rfnav_command()
    assert FLAG in rfnav_command(())
    command, _ = model_fault(parse_faults(("llm-hang",)), ())
    assert command is not None
    assert FLAG in command


SCRIPTS = sorted((ROOT / "deploy").glob("*.sh"))


def test_a_wheel_has_all_of_it_each_where_it_lies_here():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    found = set()
    for place, patterns in project["tool"]["setuptools"]["data-files"].items():
        for path in (path for pattern in patterns for path in ROOT.glob(pattern)):
            assert str(path.parent.relative_to(ROOT)).replace("deploy", "share/rf-nav", 1) == place
            found.add(path)
    assert found == {path for path in (ROOT / "deploy").rglob("*") if path.is_file()}


def test_its_scripts_can_be_run_and_a_checker_has_nothing_to_say():
    assert {path.name for path in SCRIPTS} == {"install.sh", "uninstall.sh"}
    for path in SCRIPTS:
        assert path.stat().st_mode & 0o111
        assert subprocess.run(["bash", "-n", path], check=False).returncode == 0
    if shutil.which("shellcheck") is None:
        pytest.skip("shellcheck is not installed")
    done = subprocess.run(["shellcheck", *SCRIPTS], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "")


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.name)
def test_what_is_asked_wrongly_is_refused_in_a_line(script):
    done = subprocess.run([script, "--bogus"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "--bogus: unknown; it takes --" in done.stderr


def test_a_library_is_found_in_a_list_that_is_long(tmp_path):
    """As a desktop's is: longer than what a pipe holds."""
    listed = tmp_path / "ldconfig"
    others = "seq -f 'libother%g.so.1 (libc6,x86-64) => /usr/lib/libother.so.1' 5000"
    listed.write_text(f"#!/bin/sh\necho 'libgomp.so.1 (libc6) => /usr/lib'\n{others}\n")
    listed.chmod(0o755)
    path = f"{tmp_path}:{os.environ['PATH']}"
    command = [ROOT / "deploy" / "install.sh", "--wheels", tmp_path]
    done = subprocess.run(command, env={"PATH": path}, capture_output=True, text=True, check=False)
    assert done.returncode == 2  # there is no wheel
    assert "no wheel" in done.stderr
    assert "libgomp" not in done.stderr
