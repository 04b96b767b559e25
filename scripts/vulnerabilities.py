"""See scripts/vulnerabilities. pip-audit asks; it calls what it could not ask about no
vulnerability, which is told apart here."""

import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
SERVICES = ("pypi", "osv")
NONE_KNOWN, SOME_KNOWN, ERROR, NOT_ASKED = 0, 1, 2, 3
TIMEOUT_S = 15  # of a request
SHOWN = 5  # names of what was not asked about


def main() -> int:
    if len(sys.argv) > 1:
        print("vulnerabilities: takes no arguments", file=sys.stderr)
        return ERROR
    status, lines = NOT_ASKED, ["vulnerabilities: nobody was asked"]
    for service in SERVICES:
        status, lines = verdict(service, *ask(service, ROOT / "constraints.txt"))
        if status != NOT_ASKED:
            break
        print("\n".join(lines), file=sys.stderr)
    if status == NOT_ASKED:
        lines = ["vulnerabilities: SKIPPED: nothing is known of these versions, good or bad"]
    print("\n".join(lines), file=sys.stderr if status else sys.stdout)
    return status


def ask(service: str, pins: Path) -> tuple[dict[str, Any] | None, str]:
    """pip-audit's report, None when there is none, and the last that it said."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "report.json"
        command = [sys.executable, "-m", "pip_audit", "--requirement", str(pins), "--no-deps"]
        command += ["--disable-pip", "--progress-spinner", "off", "--format", "json"]
        command += ["--output", str(out), "--vulnerability-service", service]
        command += ["--timeout", str(TIMEOUT_S)]
        done = subprocess.run(command, capture_output=True, text=True)
        said = (done.stderr.strip().splitlines() or ["nothing"])[-1]
        if done.returncode not in (0, 1) or not out.is_file():
            return None, said
        return json.loads(out.read_text(encoding="utf-8")), said


def verdict(service: str, report: Mapping[str, Any] | None, said: str) -> tuple[int, list[str]]:
    """The exit status, and what is told."""
    head = f"vulnerabilities: {service}:"
    if report is None:
        return NOT_ASKED, [f"{head} NOT ASKED: {said[:300]}"]
    pins = report["dependencies"]
    skipped = [pin["name"] for pin in pins if "skip_reason" in pin]
    lines = [
        f"{pin['name']} {pin['version']}: {', '.join((found['id'], *found['aliases']))}; "
        f"repaired in {', '.join(found['fix_versions']) or 'no version'}"
        for pin in pins
        for found in pin.get("vulns", ())
    ]
    if skipped:
        names = ", ".join(skipped[:SHOWN]) + (", …" if len(skipped) > SHOWN else "")
        lines.append(f"{head} NOT ASKED about {len(skipped)} of {len(pins)}: {names}: not there")
    if len(lines) > bool(skipped):
        return SOME_KNOWN, lines
    if skipped or not pins:
        return NOT_ASKED, lines or [f"{head} NOT ASKED: there are no versions"]
    return NONE_KNOWN, [f"{head} none known of {len(pins)} versions"]


if __name__ == "__main__":
    sys.exit(main())
