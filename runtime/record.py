"""What the parts of a loop tell a recorder, if there is one: by kind, a value that nobody changes
afterwards. `recording.recorder` has the kinds."""

from collections.abc import Callable

Record = Callable[[str, object], None]


def unrecorded(kind: str, value: object) -> None:
    """Nothing is recorded."""
