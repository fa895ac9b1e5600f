"""Finding a USB device again that has come back under another name."""

from pathlib import Path
from typing import NamedTuple


class UsbIdentity(NamedTuple):
    """What tells one USB device from others of its kind."""

    vendor: int
    product: int
    serial_number: str


def usb_identity(port: str) -> UsbIdentity | None:
    """Return the identity of the USB device behind a port; None: not USB, or without a number."""
    return _connected().get(str(Path(port).resolve()))


def find_port(identity: UsbIdentity) -> str | None:
    """Return the port that the USB device has now; None: it is not there."""
    return next((port for port, found in _connected().items() if found == identity), None)


def _connected() -> dict[str, UsbIdentity]:
    from serial.tools import list_ports  # noqa: PLC0415 - needed only when a port is opened

    return {
        port.device: UsbIdentity(port.vid, port.pid, port.serial_number)
        for port in list_ports.comports()
        if port.vid is not None and port.pid is not None and port.serial_number
    }
