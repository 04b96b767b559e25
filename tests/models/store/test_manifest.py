"""The store keeps only what the manifest's checksums admit."""

import hashlib
import shutil
import zipfile
from pathlib import Path

import pytest

from models.errors import ModelFileError
from models.store import manifest as store
from models.store import sources

CONTENT = b"weights of a small model"
SHA = hashlib.sha256(CONTENT).hexdigest()


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path


def manifest(home: Path, source: str, sha: str = SHA) -> Path:
    path = home / "manifest.toml"
    path.write_text(
        f"""[tiny]
task = "text"
default = true
licence = "Apache-2.0"
[[tiny.files]]
name = "tiny.bin"
bytes = {len(CONTENT)}
sha256 = "{sha}"
sources = [{source}]
"""
    )
    return path


def cached(home: Path) -> list[Path]:
    return [p for p in (home / "cache").rglob("*") if p.is_file()]


def test_a_file_of_the_package_is_used_where_it_lies(home: Path) -> None:
    (home / "tiny.bin").write_bytes(CONTENT)
    path = manifest(home, '{ file = "tiny.bin" }')
    assert store.fetch("tiny", manifest=path) == home / "tiny.bin"
    assert store.locate("tiny", manifest=path) == home / "tiny.bin"


def test_a_url_is_fetched_once_and_reports_progress(home: Path) -> None:
    (home / "far.bin").write_bytes(CONTENT)
    path = manifest(home, f'{{ url = "{(home / "far.bin").as_uri()}" }}')
    seen: list[tuple[int, int]] = []
    found = store.fetch("tiny", lambda _, done, total: seen.append((done, total)), path)
    assert found.read_bytes() == CONTENT
    assert seen[-1] == (len(CONTENT), len(CONTENT))
    (home / "far.bin").unlink()
    assert store.fetch("tiny", manifest=path) == found


def test_a_wrong_checksum_is_refused_and_not_kept(home: Path) -> None:
    (home / "far.bin").write_bytes(b"something else")
    path = manifest(home, f'{{ url = "{(home / "far.bin").as_uri()}" }}')
    with pytest.raises(ModelFileError, match="refused: sha256") as error:
        store.fetch("tiny", manifest=path)
    assert "\n" not in str(error.value)
    assert cached(home) == []


def test_more_than_the_manifest_says_is_not_read(home: Path) -> None:
    (home / "far.bin").write_bytes(CONTENT + b"and more")
    path = manifest(home, f'{{ url = "{(home / "far.bin").as_uri()}" }}')
    with pytest.raises(ModelFileError, match="gives more than 24 bytes, which is refused"):
        store.fetch("tiny", manifest=path)
    assert cached(home) == []


def test_a_text_lies_in_the_manifest_itself(home: Path) -> None:
    path = manifest(home, f'{{ text = "{CONTENT.decode()}" }}')
    assert store.fetch("tiny", manifest=path).read_bytes() == CONTENT


def test_what_is_not_permissive_is_fetched_when_it_is_accepted(home: Path) -> None:
    (home / "far.bin").write_bytes(CONTENT)
    path = manifest(home, f'{{ url = "{(home / "far.bin").as_uri()}" }}')
    path.write_text(path.read_text().replace("Apache-2.0", "AGPL-3.0"))
    with pytest.raises(ModelFileError, match=r"tiny: its licence is AGPL-3\.0.*pull tiny --accept"):
        store.fetch("tiny", manifest=path)
    assert cached(home) == []
    assert store.fetch("tiny", manifest=path, accepted="agpl-3.0").read_bytes() == CONTENT
    assert store.fetch("tiny", manifest=path).read_bytes() == CONTENT  # it is here now


def test_where_a_licence_can_be_read_is_told(home: Path) -> None:
    model = store.entry("lfm2.5-vl-450m")
    with pytest.raises(ModelFileError) as error:
        store.fetch(model.name)
    assert str(error.value) == (
        f"lfm2.5-vl-450m: its licence is lfm1.0 ({model.terms}), which may ask something of you; "
        "when you have read it, `rfnav models pull lfm2.5-vl-450m --accept-licence lfm1.0`"
    )
    assert model.terms.startswith("https://huggingface.co/LiquidAI/")


def test_a_file_whose_size_nobody_told_is_what_its_checksum_says(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = manifest(home, f'{{ url = "{(home / "far.bin").as_uri()}" }}')
    path.write_text(path.read_text().replace(f"bytes = {len(CONTENT)}\n", ""))
    assert store.entry("tiny", path).size == 0
    (home / "far.bin").write_bytes(CONTENT + b"!")
    with pytest.raises(ModelFileError, match="refused: sha256 is"):
        store.fetch("tiny", manifest=path)
    (home / "far.bin").write_bytes(CONTENT)
    assert store.fetch("tiny", manifest=path).read_bytes() == CONTENT
    monkeypatch.setattr(sources, "MOST_BYTES", 10)
    shutil.rmtree(store.cache_dir())
    with pytest.raises(ModelFileError, match="gives more than 10 bytes, which is refused"):
        store.fetch("tiny", manifest=path)


@pytest.mark.parametrize("name", ["smollm2-135m", "qwen3-0.6b", "smolvlm2-500m", "lfm2.5-vl-450m"])
def test_models_by_url_are_pinned(name: str) -> None:
    model = store.entry(name)
    assert len(model.files) == (2 if model.task == "vision" else 1)
    assert model.handler == ("mtmd" if model.task == "vision" else "")
    for file in model.files:
        assert len(file.sha256) == 64
        for source in file.sources:
            if source.url:
                assert source.url.startswith("https://huggingface.co/")
                assert source.url.endswith(f"/resolve/main/{file.name}")


def test_the_next_source_is_tried(home: Path) -> None:
    (home / "far.bin").write_bytes(CONTENT)
    good = f'{{ url = "{(home / "far.bin").as_uri()}" }}'
    path = manifest(home, f'{{ file = "missing.bin" }}, {{ url = "file:///nowhere" }}, {good}')
    assert store.fetch("tiny", manifest=path).read_bytes() == CONTENT


def test_missing_and_damaged_files_name_the_remedy(home: Path) -> None:
    path = manifest(home, '{ url = "file:///nowhere" }')
    with pytest.raises(ModelFileError, match="missing; run `rfnav models pull tiny`"):
        store.locate("tiny", manifest=path)
    target = home / "cache" / "rf-nav" / "models" / "tiny" / "tiny.bin"
    target.parent.mkdir(parents=True)
    target.write_bytes(CONTENT[:-1])
    with pytest.raises(ModelFileError, match=r"damaged: sha256 .*; run `rfnav models pull tiny`"):
        store.verify("tiny", manifest=path)


def test_a_damaged_file_is_fetched_anew(home: Path) -> None:
    (home / "far.bin").write_bytes(CONTENT)
    path = manifest(home, f'{{ url = "{(home / "far.bin").as_uri()}" }}')
    target = store.fetch("tiny", manifest=path)
    target.write_bytes(b"damaged")
    assert store.fetch("tiny", manifest=path).read_bytes() == CONTENT


def test_an_unknown_model_lists_the_known(home: Path) -> None:
    with pytest.raises(ModelFileError, match=r"no such model; known are .*minilm"):
        store.fetch("nonesuch")


def test_a_manifest_with_a_missing_key_names_the_model(home: Path) -> None:
    path = home / "manifest.toml"
    path.write_text('[tiny]\ntask = "text"\n')
    with pytest.raises(ModelFileError, match="model 'tiny': wrong or missing key: 'files'"):
        store.load_manifest(path)


def test_a_wheel_that_lacks_the_member(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wheel = home / "a.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("pkg/data.bin", CONTENT)
    monkeypatch.setattr(sources, "_download_wheel", lambda *_: wheel)
    good = manifest(home, '{ pypi = "pkg==1", member = "pkg/data.bin" }')
    assert store.fetch("tiny", manifest=good).read_bytes() == CONTENT
    store.fetch("tiny", manifest=good).unlink()
    bad = manifest(home, '{ pypi = "pkg==1", member = "pkg/other.bin" }')
    with pytest.raises(ModelFileError, match=r"pkg==1: holds no pkg/other\.bin"):
        store.fetch("tiny", manifest=bad)


def test_a_failed_download_is_one_line(home: Path) -> None:
    path = manifest(home, '{ pypi = "rf-nav-no-such-package==0 .. bad", member = "x" }')
    with pytest.raises(ModelFileError, match=r"pip download .* failed: ERROR") as error:
        store.fetch("tiny", manifest=path)
    assert "\n" not in str(error.value)
    assert cached(home) == []


def test_a_file_goes_by_the_name_of_the_model_whose_bytes_it_has(tmp_path: Path) -> None:
    copy, other = tmp_path / "mine.onnx", tmp_path / "nanodet-g.onnx"
    shutil.copy(store.locate("nanodet-g"), copy)
    other.write_bytes(copy.read_bytes()[:-1] + b"?")
    missing, folder = tmp_path / "none.onnx", tmp_path / "clip.d"
    folder.mkdir()
    assert store.called(str(copy)) == store.called("nanodet-g") == "nanodet-g"
    for path in map(str, (other, missing, folder)):
        assert store.called(path) == path
        assert store.located(path) == Path(path)
    assert store.located("nanodet-g") == store.locate("nanodet-g")


def test_the_shipped_manifest_is_complete() -> None:
    known = store.load_manifest()
    assert {"smollm2-135m", "minilm", "efficientnet-lite0"} <= set(known)
    assert all(len(f.sha256) == 64 and f.sources for e in known.values() for f in e.files)


def test_a_model_is_its_first_file_and_a_path_to_a_file_is_that(tmp_path: Path) -> None:
    folder = tmp_path / "two.files"
    folder.mkdir()
    for name in ("b.gguf", "a.gguf"):
        (folder / name).touch()
    assert store.first_file(str(folder)) == folder / "a.gguf"
    assert store.first_file(str(folder / "b.gguf")) == folder / "b.gguf"
