"""Which names the scene-layout expert was never taught, as the lists of its training have them."""

import tomllib
from pathlib import Path

from runtime.errors import RfNavError

TRAINING = Path(__file__).parents[2] / "models" / "train"


def never_taught(folder: Path = TRAINING) -> frozenset[str]:
    """Categories of which no name was ever taught to the projector; of some the detector, whose
    features it sees, was taught them. RfNavError when the lists cannot be read."""
    try:
        detector, projector = (
            tomllib.loads((folder / name).read_text(encoding="utf-8"))
            for name in ("names.toml", "beyond.toml")
        )
        return frozenset({*detector["held_out"], *projector["never_trained"]})
    except (OSError, ValueError, KeyError) as error:
        raise RfNavError(
            f"{folder}: no lists of names that were never taught ({error!r}); they are in the "
            "repository, not in a wheel"
        ) from error
