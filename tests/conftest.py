"""Shared by all tests: helper modules beside the tests that use them can be imported by name."""

import sys
from pathlib import Path

from hypothesis import settings

settings.register_profile("untimed", deadline=None)  # correctness tests do not time
settings.load_profile("untimed")

sys.path[:0] = [str(Path(__file__).parent / "runtime" / part) for part in (".", "core")]
sys.path[:0] = [str(Path(__file__).parent / part) for part in ("hil_sim", "models")]
