"""TOML files, bounded before they are parsed."""

import tomllib
from pathlib import Path
from typing import Any, Final

FILE_BYTES: Final = 4 << 20
DOTS: Final = 1000  # of a line: a dotted key costs the parser the square of its parts


def read_toml(path: Path) -> dict[str, Any]:
    """A file's tables. OSError, or ValueError for what is no TOML; both of one line."""
    with path.open("rb") as file:
        data = file.read(FILE_BYTES + 1)
    if len(data) > FILE_BYTES:
        raise ValueError(f"larger than {FILE_BYTES >> 20} MiB")
    if any(line.count(b".") > DOTS for line in data.splitlines()):
        raise ValueError(f"a line with more than {DOTS} dots")
    try:
        return tomllib.loads(data.decode("utf-8"))
    except RecursionError as error:
        raise ValueError("nested too deep") from error
