"""The errors that laserfeatures raises.

::

    LaserFeaturesError
    ├── UnknownExtractorError  (LookupError)   no extractor has that name
    ├── PluginError                            an extractor cannot be loaded or breaks its contract
    ├── MissingDependencyError (ImportError)   an optional package is not installed
    ├── SourceError            (OSError)       a log, bag or plan cannot be read
    ├── DriveError             (RuntimeError)  a simulated robot cannot go on
    └── DriverError            (OSError)       a device cannot be opened or answers wrongly
        ├── DeviceLostError                    a device was unplugged, or its port closed
        ├── DriverTimeoutError (TimeoutError)  a device does not answer in time
        └── ProtocolError                      a device's answer is not what its protocol says

A wrong argument is a plain ``ValueError`` or ``TypeError``.
"""

LONGEST = 300  # characters that are shown of another's words


def shown(text: str, longest: int = LONGEST) -> str:
    """Return text of others in one line of bounded length, without control characters.

    What is too long loses its middle.
    """
    if len(text) > 4 * longest:  # no need to look at all of it
        text = f"{text[: 2 * longest]} .. {text[-2 * longest :]}"
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in " ".join(text.split()))
    if len(line) <= longest:
        return line
    end = longest // 3
    return f"{line[: longest - end - 4]} .. {line[-end:]}"


class LaserFeaturesError(Exception):
    """Catch every error that laserfeatures raises on purpose."""


class UnknownExtractorError(LaserFeaturesError, LookupError):
    """No extractor is registered under the name asked for."""


class PluginError(LaserFeaturesError):
    """An extractor's plugin cannot be loaded, or what it returned breaks the contract."""


class MissingDependencyError(LaserFeaturesError, ImportError):
    """A package of an optional extra is needed and not installed; the message names the extra."""


class SourceError(LaserFeaturesError, OSError):
    """A log, bag or plan cannot be read; the message names file, line, expected and found."""


class DriveError(LaserFeaturesError, RuntimeError):
    """A simulated robot cannot go on: it does not fit, is stuck, or has tipped over."""


class DriverError(LaserFeaturesError, OSError):
    """A device cannot be opened or used."""


class DeviceLostError(DriverError):
    """A device is gone: unplugged, or its port was closed by the other end."""


class DriverTimeoutError(DriverError, TimeoutError):
    """A device did not answer in time."""


class ProtocolError(DriverError):
    """A device's answer is not what its protocol says."""
