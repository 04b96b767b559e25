"""Where things lie: the checkout, its tests, the stand-ins, and what may be shared beside it."""

import os
from pathlib import Path

DOUBLES = Path(__file__).parent
TESTS = DOUBLES.parent
ROOT = TESTS.parent
SHARED = Path(os.environ.get("RFNAV_SHARED") or ROOT.parent / "shared")
