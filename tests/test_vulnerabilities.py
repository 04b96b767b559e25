"""What was not asked about is never told to be free of holes."""

import importlib.util
import sys
from typing import Any

import pytest
from places import ROOT


def _load() -> Any:
    path = ROOT / "scripts" / "vulnerabilities.py"
    spec = importlib.util.spec_from_file_location("vulnerabilities", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


script = _load()
FREE = {"name": "numpy", "version": "2.4.6", "vulns": []}
HOLE = {"id": "PYSEC-1", "aliases": ["CVE-2026-1"], "fix_versions": ["5.6.4"]}
HOLED = {"name": "diskcache", "version": "5.6.3", "vulns": [HOLE]}
SKIPPED = {"name": "mcap", "skip_reason": "Dependency not found on PyPI"}


@pytest.mark.parametrize(
    ("pins", "status", "told"),
    [
        ([FREE, FREE], 0, ["vulnerabilities: pypi: none known of 2 versions"]),
        ([FREE, HOLED], 1, ["diskcache 5.6.3: PYSEC-1, CVE-2026-1; repaired in 5.6.4"]),
        ([FREE, SKIPPED], 3, ["pypi: NOT ASKED about 1 of 2: mcap: not there"]),
        ([SKIPPED] * 9, 3, ["NOT ASKED about 9 of 9: mcap, mcap, mcap, mcap, mcap, …"]),
        ([HOLED, SKIPPED], 1, ["diskcache 5.6.3: ", "NOT ASKED about 1 of 2"]),
        ([], 3, ["NOT ASKED: there are no versions"]),
    ],
)
def test_the_status_says_what_was_asked(pins: list[Any], status: int, told: list[str]) -> None:
    found, lines = script.verdict("pypi", {"dependencies": pins}, "")
    assert found == status
    assert len(lines) == len(told)
    assert all(part in line for part, line in zip(told, lines, strict=True))


def test_without_a_report_nothing_was_asked() -> None:
    assert script.verdict("osv", None, "ConnectionError: no route") == (
        3, ["vulnerabilities: osv: NOT ASKED: ConnectionError: no route"],
    )  # fmt: skip


def test_without_a_network_it_says_so_loudly(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """pip-audit itself, sent to where nobody listens."""
    for name in ("HTTP_PROXY", "HTTPS_PROXY", "http_proxy", "https_proxy", "ALL_PROXY"):
        monkeypatch.setenv(name, "http://127.0.0.1:9")
    monkeypatch.delenv("NO_PROXY", raising=False)
    monkeypatch.delenv("no_proxy", raising=False)
    monkeypatch.setattr(sys, "argv", ["vulnerabilities"])
    assert script.main() == 3
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(" NOT ASKED")[0] for line in lines[:-1]] == [
        "vulnerabilities: pypi:",
        "vulnerabilities: osv:",
    ]
    assert lines[-1].startswith("vulnerabilities: SKIPPED: nothing is known")
