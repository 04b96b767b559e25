#!/usr/bin/env python3
"""What scripts/fuzz runs: one process an entry point of tests/fuzz/entry_points.py, and a table of
inputs, crashes, seconds and memory. Exit status 1 when an input ended one, or took over a second.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "fuzz"
SHARES = {  # of all inputs; what opens files is a hundred times as slow
    "messages": 0.15, "doctor": 0.02, "images": 0.08, "mavlink": 0.08, "requests": 0.12,
    "ros": 0.06, "configuration": 0.10, "scenes": 0.08, "manifest": 0.05, "vocabulary": 0.06,
    "onnx": 0.08, "gguf": 0.055, "journals": 0.018, "goals": 0.01, "recordings": 0.005,
    "sh3d": 0.005, "sh3d drawings": 0.005, "scores": 0.002, "spending": 0.002, "zones": 0.002,
    "memories": 0.013, "places": 0.002,
    "embeddings": 0.001,
}  # fmt: skip
LONGEST_S = 1.0  # of computing, for one input
WAITED_S = 9.0  # for anything else than a processor, for one input
STUCK_S = 60  # after which libFuzzer ends it
MEMORY_MB = 2048
LARGEST_INPUT = 1 << 16


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1_000_000, help="inputs in all")
    parser.add_argument("--json", type=Path, help="the table's figures, as JSON")
    parser.add_argument("--one", help=argparse.SUPPRESS)
    parser.add_argument("entries", nargs="*", metavar="ENTRY", help=", ".join(SHARES))
    told = parser.parse_args()
    if told.one:
        fuzz(told.one, told.runs)
    names = told.entries or list(SHARES)
    if unknown := set(names) - set(SHARES):
        parser.error(f"no entry {min(unknown)!r}; known are {', '.join(SHARES)}")
    whole = sum(SHARES[name] for name in names)
    rows = [run(name, round(told.runs * SHARES[name] / whole)) for name in names]
    print(table(rows))
    if told.json:
        told.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    return int(any(row["ended_by"] for row in rows))


def run(name: str, runs: int) -> dict[str, object]:
    """One entry point, in a process of its own."""
    began_s = time.monotonic()
    command = [sys.executable, str(Path(__file__)), "--one", name, "--runs", str(max(1, runs))]
    done = subprocess.run(
        command, cwd=ROOT, capture_output=True, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    said = done.stderr.decode(errors="replace")
    OUT.mkdir(parents=True, exist_ok=True)
    (OUT / f"{slug(name)}.log").write_text(said, encoding="utf-8")
    executed, peak_mb = (_stat(said, key) for key in ("number_of_executed_units", "peak_rss_mb"))
    ended_by = re.findall(r"Test unit written to (\S+)", said)
    if done.returncode and not ended_by:
        ended_by = [f"status {done.returncode}: see {OUT / slug(name)}.log"]
    row: dict[str, object] = {
        "entry": name, "inputs": executed, "ended_by": ended_by,
        "seconds": round(time.monotonic() - began_s, 1), "peak_mb": peak_mb,
    }  # fmt: skip
    print(json.dumps(row), file=sys.stderr, flush=True)
    return row


def table(rows: list[dict[str, object]]) -> str:
    """In Markdown."""
    lines = ["| input | tried | crashes or over 1 s | s | MB at most |", "|---|---|---|---|---|"]
    for row in rows:
        ended = len(row["ended_by"])  # type: ignore[arg-type]
        figures = f"{row['inputs']:,} | {ended} | {row['seconds']:,.0f} | {row['peak_mb']}"
        lines.append(f"| {row['entry']} | {figures} |")
    tried, ended, took = (
        sum(row["inputs"] for row in rows),  # type: ignore[misc]
        sum(len(row["ended_by"]) for row in rows),  # type: ignore[arg-type, misc]
        sum(row["seconds"] for row in rows),  # type: ignore[misc]
    )
    most = max(row["peak_mb"] for row in rows)  # type: ignore[type-var]
    return "\n".join([*lines, f"| all | {tried:,} | {ended} | {took:,.0f} | {most} |"])


def slug(name: str) -> str:
    return name.replace(" ", "-")


def _stat(said: str, name: str) -> int:
    found = re.search(rf"stat::{name}:\s+(\d+)", said)
    return int(found[1]) if found else 0


def fuzz(name: str, runs: int) -> None:
    """In the process of its own; it ends here."""
    import atheris

    for room in ("doubles", "fuzz"):
        sys.path.insert(0, str(ROOT / "tests" / room))
    with atheris.instrument_imports(include=["runtime", "models", "hil_sim", "tomllib", "mcap"]):
        from entry_points import ENTRY_POINTS
    entry = ENTRY_POINTS[name]
    corpus = OUT / "corpus" / slug(name)
    corpus.mkdir(parents=True, exist_ok=True)
    for number, seed in enumerate(entry.seeds):
        (corpus / f"seed-{number}").write_bytes(seed)

    def one(data: bytes) -> None:
        began_s, computed_s = time.monotonic(), time.thread_time()
        entry.run(data)
        took_s, computed_s = time.monotonic() - began_s, time.thread_time() - computed_s
        assert computed_s <= LONGEST_S, f"{computed_s:.1f} s for one input"
        assert took_s - computed_s <= WAITED_S, f"{took_s:.1f} s waited with one input"

    atheris.Setup(
        [
            sys.argv[0], str(corpus), f"-runs={runs}", f"-timeout={STUCK_S}",
            f"-rss_limit_mb={MEMORY_MB}", f"-max_len={LARGEST_INPUT}", "-print_final_stats=1",
            f"-artifact_prefix={OUT / slug(name)}-",
        ],
        one,
    )  # fmt: skip
    atheris.Fuzz()


if __name__ == "__main__":
    sys.exit(main())
