"""A process that only sleeps: what it says of itself."""

import json
import subprocess
import sys
import time


def test_it_counts_since_it_was_cleared_and_says_so_when_its_input_ends():
    command = [sys.executable, "-m", "runtime.bench.sleeper", "50"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdin is not None
    time.sleep(0.5)
    process.stdin.write("clear\n")
    process.stdin.flush()
    time.sleep(1.0)
    said, _ = process.communicate(timeout=30)
    told = json.loads(said)
    assert 5 <= told["n"] <= 75
    assert 0 <= told["p50_ms"] <= told["p99_ms"] <= told["max_ms"]
