"""Furniture: fetched from Debian's archive into a cache, never installed, converted when used."""

import os
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from functools import cached_property
from pathlib import Path

from tqdm import tqdm

from hil_sim.scenes.furniture.catalog import Catalog, CatalogError
from hil_sim.scenes.furniture.meshes import Mesh, builtin, convert, load_mesh
from hil_sim.scenes.furniture.shapes.named import BUILTINS

PACKAGE = "sweethome3d-furniture"
CATALOGUES = ("BlendSwap-CC-0", "BlendSwap-CC-BY", "KatorLegaz", "Reallusion", "Scopia")


def cache_dir() -> Path:
    """$XDG_CACHE_HOME/rf-nav."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "rf-nav"


class Assets:
    """The furniture in the cache; CatalogError, with the remedy, when it has not been pulled."""

    def __init__(self, cache: Path | None = None) -> None:
        self._cache = cache or cache_dir()
        self.root = self._cache / "furniture"

    @property
    def present(self) -> bool:
        """Whether the catalogues are in the cache, whole."""
        return all((self.root / name).is_dir() for name in CATALOGUES)

    @cached_property
    def catalog(self) -> Catalog:
        """The catalogues' entries."""
        if not self.present:
            raise CatalogError(f"{self.root}: no furniture here; run `hil-sim assets pull`")
        return Catalog(self.root)

    def known(self, wanted: Iterable[str]) -> set[str]:
        """The names of meshes there are; the catalogues are read only if one of them is wanted."""
        names = {f"builtin:{name}" for name in BUILTINS}
        return names | set(self.catalog.models) if any("#" in w for w in wanted) else names

    def mesh(self, name: str, base: Path | None = None) -> Mesh:
        """A catalogue id, "builtin:NAME", or the path of an OBJ relative to `base`; converted
        once, then read from the cache."""
        store = self._cache / "meshes"
        if name.startswith("builtin:"):
            return builtin(name.removeprefix("builtin:"), store)
        if "#" not in name:
            path = (base or Path()) / name
            if not path.is_file():
                raise CatalogError(
                    f"{path}: no such mesh; give a catalogue id, builtin:NAME or OBJ"
                )
            return convert(path, None, None, store)
        model = self.catalog.model(name)
        return load_mesh(model, store)


def pull(assets: Assets, report: Callable[[str], None]) -> Path:
    """Fetch and unpack the furniture unless it is there. CatalogError says what to do."""
    if assets.present:
        return assets.root
    assets.root.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=assets.root.parent) as scratch:
        work = Path(scratch)
        package = _download(work, report)
        report(f"unpacking {package.name}")
        _run(["dpkg-deb", "-x", str(package), str(work / "deb")])
        fresh = work / "furniture"
        for name in CATALOGUES:
            archive = work / "deb/usr/share/sweethome3d/furniture" / f"{name}.sh3f"
            try:
                with zipfile.ZipFile(archive) as file:
                    file.extractall(fresh / name)
            except (OSError, zipfile.BadZipFile) as error:
                raise CatalogError(
                    f"{archive.name}: not in the package or damaged: {error}"
                ) from error
        shutil.rmtree(assets.root, ignore_errors=True)
        fresh.rename(assets.root)
    return assets.root


def _download(work: Path, report: Callable[[str], None]) -> Path:
    """`apt-get download` checks the archive's signature and checksum; it needs no root."""
    work.chmod(0o755)
    for attempt in range(2):
        try:
            _apt_download(work)
        except CatalogError:
            if attempt or os.geteuid() != 0:
                raise
            report("updating the package lists")
            _run(["apt-get", "update", "-qq"])
        else:
            return next(work.glob("*.deb"))
    raise AssertionError("unreachable")


def _apt_download(work: Path) -> None:
    read_fd, write_fd = os.pipe()
    command = ["apt-get", "download", "-q", "-o", f"APT::Status-Fd={write_fd}", PACKAGE]
    try:
        process = subprocess.Popen(
            command,
            cwd=work,
            pass_fds=(write_fd,),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
    except FileNotFoundError as error:
        os.close(read_fd)
        raise CatalogError(
            f"apt-get: not found; fetch Debian's {PACKAGE} on another machine and unpack its .sh3f "
            "files into the cache"
        ) from error
    finally:
        os.close(write_fd)
    with os.fdopen(read_fd) as status, tqdm(total=100, unit="%", desc=PACKAGE, disable=None) as bar:
        for line in status:
            fields = line.split(":")
            if fields[0] == "dlstatus" and len(fields) > 2:
                bar.update(float(fields[2]) - bar.n)
    _, errors = process.communicate()
    if process.returncode or not list(work.glob("*.deb")):
        lines = [line for line in errors.splitlines() if line.startswith("E:")] or ["failed"]
        raise CatalogError(
            f"apt-get download {PACKAGE}: {lines[0]}; run `sudo apt-get update`, then try again"
        )


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise CatalogError(f"{command[0]}: {' '.join(done.stderr.split())[:200]}")
