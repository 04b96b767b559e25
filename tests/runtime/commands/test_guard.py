"""`rfnav guard` is the watchdog itself, in place of the command line."""

import subprocess
import sys


def test_the_command_becomes_the_watchdog():
    words = [sys.executable, "-m", "runtime", "guard"]
    helped = subprocess.run([*words, "--help"], capture_output=True, text=True, timeout=120)
    assert helped.returncode == 0
    assert helped.stdout.startswith("usage: rfnav guard ")
    wrong = subprocess.run([*words, "--nonsense"], capture_output=True, text=True, timeout=120)
    assert wrong.returncode == 2
    assert "one of the arguments --socket --fd is required" in wrong.stderr
