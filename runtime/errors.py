"""The errors a user can meet. Each message is one line: the place, what is wrong, what is right."""


class RfNavError(Exception):
    """Base of every error that is the input's or the environment's fault, not the program's."""


class ConfigError(RfNavError):
    """A configuration file, key or command-line value that cannot be used."""


class NotLocalisedError(ConfigError):
    """What is asked for lies on a saved map, and nobody knows where the robot is on that."""


class ModelError(RfNavError):
    """A model file that is missing, damaged or of another contract."""


class SensorError(RfNavError):
    """A sensor message that contradicts itself or its siblings."""


class BusError(RfNavError):
    """The Zenoh session could not be opened or used."""


class SilentError(BusError):
    """Who was asked over it is there, and has not answered in time."""


class InternalError(RfNavError):
    """A mistake of our own that ended a loop; the base was brought to rest first."""


class RecordingError(RfNavError):
    """A recording that cannot be written, or cannot be read as one."""


class BaseError(RfNavError):
    """The wire to the base could not be opened or used."""


class SavedError(RfNavError):
    """What outlives the process cannot be written, or cannot be read as what it is."""
