"""The one error of this package; the composition root maps it to the program's own."""


class ModelError(Exception):
    """A model file, name or class list that cannot be used. One line: place, fault, remedy."""


class OverdueError(ModelError):
    """A model had not answered in the time it was given."""
