"""Another commit of this checkout, ready to run beside this one."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from runtime.bench.measure import BenchError


@contextmanager
def checkout(here: Path, rev: str) -> Iterator[Path]:
    """A commit of the checkout `here` in a folder of its own, its kernels compiled. BenchError
    where git does not know it, or it does not compile."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "against"
        _run("git", "-C", str(here), "worktree", "add", "--detach", str(root), rev)
        try:
            if (root / "setup.py").exists():
                _run(sys.executable, "setup.py", "-q", "build_ext", "--inplace", cwd=root)
            yield root
        finally:
            _run("git", "-C", str(here), "worktree", "remove", "--force", str(root))


def _run(*command: str, cwd: Path | None = None) -> None:
    done = subprocess.run(command, capture_output=True, text=True, cwd=cwd)
    if done.returncode:
        said = (done.stderr.strip().splitlines() or [f"{command[0]} failed"])[-1]
        raise BenchError(f"--against: {said}")
