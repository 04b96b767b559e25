"""Models of other people that methods need, and whether they were imported.

The list of those is what `rfnav models import` writes.
"""

import os
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

from runtime.errors import ConfigError


class Needed(NamedTuple):
    """A model by the name and the contract that a method asks for, and how to get it in."""

    name: str
    contract: str
    what: str
    files: str

    def identity(self, method: str) -> str:
        """The checksums of its files; ConfigError when it is not here for `method` to use."""
        entry = _imported().get(self.name)
        remedy = f"`rfnav models import {self.files} --as {self.name}` takes it in: {self.what}"
        if entry is None:
            raise ConfigError(f"method {method}: model {self.name} is not here; {remedy}")
        contract = str(entry.get("contract"))
        if not contract.startswith(self.contract):
            raise ConfigError(
                f"method {method}: model {self.name} is of contract {contract!r}, not "
                f"{self.contract!r}; {remedy}"
            )
        return " ".join(str(file.get("sha256")) for file in entry.get("files", []))


TOWERS = "image.onnx --texts text/model.onnx"
CLIP = Needed("clip", "clip", "CLIP's image and text tower, tokenizer.json beside that", TOWERS)
CLIP_WITH_RELEVANCE = Needed(
    "clip", "clip with relevance", "CLIP's towers, the image's with a relevance map for a text",
    TOWERS,
)  # fmt: skip
MDETR = Needed(
    "mdetr", "grounding", "a caption goes in, boxes come out", "mdetr.onnx --texts tokenizer.json"
)


def _imported() -> dict[str, Any]:
    """By name, as `rfnav models import` has entered them; {} before the first."""
    base = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    path = Path(base) / "rf-nav" / "models.toml"
    try:
        return tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    except (OSError, ValueError) as error:
        raise ConfigError(f"{path}: not a readable list of models ({error})") from error
