"""scripts/deb: a package of what scripts/bundle has put together."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from places import ROOT

SCRIPT = ROOT / "scripts" / "deb"

pytestmark = pytest.mark.skipif(shutil.which("dpkg-deb") is None, reason="dpkg-deb is not here")


def run(*command: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)


def test_it_carries_the_bundle_and_installs_and_removes_by_its_scripts(tmp_path: Path) -> None:
    bundle, package, out = (tmp_path / name for name in ("bundle", "rf-nav.deb", "out"))
    (bundle / "wheels").mkdir(parents=True)
    wheel = bundle / "wheels" / "rf_nav-1.2.3-cp311-abi3-linux_x86_64.whl"
    wheel.write_bytes(b"wheel")
    os.utime(wheel, (0, 1_800_000_000))
    for name in ("install.sh", "uninstall.sh"):
        shutil.copy(ROOT / "deploy" / name, bundle)
    done = run(SCRIPT, bundle, package)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert run("dpkg-deb", "-f", package, "Package", "Version").stdout == (
        "Package: rf-nav\nVersion: 1.2.3+20270115080000\n"  # a later one upgrades it
    )
    assert run("dpkg-deb", "-R", package, out).returncode == 0
    assert (out / "usr/share/rf-nav/install.sh").stat().st_mode & 0o777 == 0o755
    assert list((out / "usr/share/rf-nav/wheels").iterdir())
    for name in ("postinst", "prerm", "postrm"):
        assert run("bash", "-n", out / "DEBIAN" / name).returncode == 0
    assert run(out / "DEBIAN/postinst", "abort-upgrade").returncode == 0  # not to be installed
    assert run(out / "DEBIAN/prerm", "upgrade").returncode == 0
    assert run(out / "DEBIAN/postrm", "remove").returncode == 0


def test_whatever_umask_it_is_made_with_everybody_may_read_what_it_installs(tmp_path: Path) -> None:
    """Its folders are those of the system from / on, out of which nobody is to be shut."""
    bundle, package, out = (tmp_path / name for name in ("bundle", "rf-nav.deb", "out"))
    private = f"""
        umask 077
        mkdir -p {bundle}/wheels {bundle}/models/detector
        touch {bundle}/wheels/rf_nav-1.2.3-cp311-abi3-any.whl {bundle}/models/detector/m.onnx
        cp {ROOT}/deploy/*install.sh {bundle}
        {SCRIPT} {bundle} {package}
    """
    done = run("bash", "-euc", private)
    assert done.returncode == 0, done.stderr
    assert run("dpkg-deb", "-e", package, out).returncode == 0
    found = {path.name: path.stat().st_mode & 0o777 for path in out.iterdir()}
    assert found == {"control": 0o644} | dict.fromkeys(("postinst", "prerm", "postrm"), 0o755)
    listed = [line.split() for line in run("dpkg-deb", "-c", package).stdout.splitlines()]
    assert len(listed) == 7 + 4  # folders, / among them, and files
    for mode, *_, name in listed:
        runs = name.endswith(("/", ".sh"))
        assert mode[1:] == ("rwxr-xr-x" if runs else "rw-r--r--"), name


def test_what_is_no_bundle_is_told_in_a_line(tmp_path: Path) -> None:
    done = run(SCRIPT, tmp_path, tmp_path / "x.deb")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "is no bundle; scripts/bundle makes one" in done.stderr
