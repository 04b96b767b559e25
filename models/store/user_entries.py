"""What a user took in: `$XDG_DATA_HOME/rf-nav/models.toml`, in the manifest's format."""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from models.checksum import sha256
from models.errors import ModelFileError
from models.store import manifest
from models.store.sources import Source
from models.toml_text import read_toml

HEAD = "# Models that `rfnav models import` and `rfnav models add` took in.\n"


def enter(name: str, home: Path, origins: Mapping[str, Source], **about: str) -> None:
    """Write down a model whose files lie in `home`, where each came from, and its checksum as it is
    now. A name that is there is replaced. Raises ModelFileError."""
    path = manifest.user_manifest()
    try:
        known = read_toml(path) if path.is_file() else {}
        known[name] = about | {
            "files": [
                {
                    "name": file,
                    "bytes": (home / file).stat().st_size,
                    "sha256": sha256(home / file),
                    "sources": [{k: v for k, v in asdict(source).items() if v}],
                }
                for file, source in origins.items()
            ]
        }
        partial = path.with_suffix(".partial")
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.write_text(HEAD + "".join(_section(n, body) for n, body in known.items()), "utf-8")
        os.replace(partial, path)
    except OSError as error:
        raise ModelFileError(f"{path}: cannot be written ({error.strerror})") from error
    except ValueError as error:
        raise ModelFileError(f"{path}: not a readable manifest ({error})") from error


def _section(name: str, body: Mapping[str, Any]) -> str:
    lines = [f"\n[{_toml(name)}]"]
    lines += [f"{key} = {_toml(value)}" for key, value in body.items() if key != "files"]
    for file in body["files"]:
        sources = ", ".join(
            f"{{ {', '.join(f'{key} = {_toml(value)}' for key, value in source.items())} }}"
            for source in file["sources"]
        )
        lines.append(f"[[{_toml(name)}.files]]")
        lines += [f"{key} = {_toml(file[key])}" for key in ("name", "bytes", "sha256")]
        lines.append(f"sources = [{sources}]")
    return "\n".join(lines) + "\n"


def _toml(value: object) -> str:
    """A string or a number as TOML; JSON's escapes are TOML's."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
