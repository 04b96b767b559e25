"""Shared by all tests: the stand-ins in `doubles` can be imported by name."""

import os
import sys
from pathlib import Path

from hypothesis import settings

# Correctness tests do not time, and the same code gives the same verdict. New examples, and many:
# HYPOTHESIS_PROFILE=explore scripts/test -m "not slow"
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

sys.path.insert(0, str(Path(__file__).parent / "doubles"))
