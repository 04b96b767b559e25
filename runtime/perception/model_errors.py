"""The boundary at which a fault of `models/` becomes one of the runtime's."""

from collections.abc import Iterator
from contextlib import contextmanager

from models.errors import ModelFileError
from runtime.errors import ModelError


@contextmanager
def models_told() -> Iterator[None]:
    """Around a block, or as a decorator: ModelFileError is ModelError, with the same line."""
    try:
        yield
    except ModelFileError as error:
        raise ModelError(str(error)) from error
