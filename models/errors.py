"""The one error of this package; who opens models maps it to the program's own."""

import sys
from collections.abc import Callable


class ModelFileError(Exception):
    """A model file, name or class list that cannot be used. One line: place, fault, remedy."""


class OverdueError(ModelFileError):
    """A model had not answered in the time it was given."""


def told(main: Callable[[], object]) -> None:
    """Run the command of the module that was started; ModelFileError is one line and status 2."""
    try:
        main()
    except ModelFileError as error:
        spec = sys.modules["__main__"].__spec__
        name = spec.name.removesuffix(".__main__") if spec else sys.argv[0]
        print(f"{name}: {error}", file=sys.stderr)
        raise SystemExit(2) from None
