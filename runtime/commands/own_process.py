"""A command's own process, in place of that of `rfnav`, which has loaded what the other commands
need."""

import json
import os
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from runtime.errors import ConfigError


def check_packages(command: str, packages: Sequence[str], extra: str) -> None:
    """ConfigError, one line, that says how those come that are missing."""
    missing = [name for name in packages if find_spec(name) is None]
    if missing:
        told = f"needs {', '.join(missing)}: pip install 'rf-nav[{extra}]'"
        raise ConfigError(f"rfnav {command}: {told}")


def become(module: str, given: Mapping[str, Any]) -> None:
    """Run a module, which is told what was given. Python imports what lies where a process stands;
    that of a client of agents may stand among files of a stranger."""
    told = {name: str(v) if isinstance(v, Path) else v for name, v in given.items()}
    stands = sys.path[:1] in ([""], [os.getcwd()])  # `python -m runtime`, in a checkout
    sys.stdout.flush()
    safe = () if stands else ("-P",)
    os.execv(sys.executable, [sys.executable, *safe, "-m", module, json.dumps(told)])
