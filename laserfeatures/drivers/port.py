"""A serial port whose errors say what to do."""

import errno
import grp
import os
import select
from pathlib import Path
from typing import Any

from laserfeatures.errors import DeviceLostError, DriverError

LARGEST_READ = 1 << 16
URL_MARK = "://"
MODEM_LINES_MISSING = {errno.ENOTTY, errno.EINVAL, errno.EOPNOTSUPP}


class Port:
    """An open port: a device file, or what else pyserial opens by URL (``socket://``, ``loop://``).

    Parameters
    ----------
    name : str
        Such as ``/dev/ttyACM0`` or ``socket://192.168.0.10:10940``.
    baud : int
        Its rate [Bd]; without effect on USB devices and sockets.

    Raises
    ------
    DriverError
        If it cannot be opened; the message says why and what to do.
    """

    def __init__(self, name: str, baud: int) -> None:
        self.name = name
        self._serial = _open(name, baud)
        try:
            self._descriptor: int | None = self._serial.fileno()
        except (OSError, AttributeError):
            self._descriptor = None  # loop:// has none

    @property
    def baud(self) -> int:
        """Its rate [Bd]."""
        return int(self._serial.baudrate)

    @baud.setter
    def baud(self, baud: int) -> None:
        try:
            self._serial.baudrate = baud
        except (OSError, ValueError) as error:
            raise DriverError(f"{self.name}: cannot be set to {baud} Bd: {_why(error)}") from error

    def read(self, timeout: float) -> bytes:
        """Return the bytes that have come; wait at most `timeout` [s] for the first, then b"".

        Raises
        ------
        DeviceLostError
            If the port is gone: unplugged, or closed by its other end.
        """
        try:
            if self._descriptor is None:
                self._serial.timeout = timeout
                data = bytes(self._serial.read(1))
                return data + bytes(self._serial.read(self._serial.in_waiting)) if data else data
            if not select.select([self._descriptor], [], [], timeout)[0]:
                return b""
            data = os.read(self._descriptor, LARGEST_READ)
        except (OSError, TypeError, ValueError) as error:  # closed under our feet: pyserial's None
            raise self._lost(error) from error
        if not data:
            raise self._lost(None)
        return data

    def write(self, data: bytes) -> None:
        """Send bytes.

        Raises
        ------
        DeviceLostError
            If the port is gone.
        """
        try:
            self._serial.write(data)
        except OSError as error:  # serial.SerialException is one
            raise self._lost(error) from error

    def set_dtr(self, on: bool) -> bool:
        """Set the line DTR; return whether the port has one (a pseudo-terminal has not)."""
        try:
            self._serial.dtr = on
        except OSError as error:
            if error.errno in MODEM_LINES_MISSING:
                return False
            raise self._lost(error) from error
        return True

    def close(self) -> None:
        """Close it; a lost port closes, too."""
        try:
            self._serial.close()
        except OSError:
            self._serial.fd = None  # there is nothing left to close

    def _lost(self, error: BaseException | None) -> DeviceLostError:
        return DeviceLostError(
            f"{self.name}: the device is gone ({_why(error) if error else 'end of data'}): plug it "
            "in again and start anew, or use reconnect=True (--reconnect) to wait for it"
        )


def _open(name: str, baud: int) -> Any:
    import serial  # noqa: PLC0415 - 20 ms, which a command without a port need not wait for

    _check_file(name)
    try:
        return serial.serial_for_url(name, baudrate=baud, timeout=0, exclusive=_exclusive(name))
    except (OSError, ValueError) as error:
        raise DriverError(f"{name}: {_advice(name, baud, error)}") from error


def _exclusive(name: str) -> bool | None:
    return None if URL_MARK in name else True


def _check_file(name: str) -> None:
    if URL_MARK in name:
        return
    if not Path(name).exists():
        raise DriverError(
            f"{name}: there is no such port; {_ports_there()}: check the cable and the name"
        )
    if not Path(name).is_char_device():
        raise DriverError(f"{name}: expected a serial port, got a {_kind(Path(name))}")


def _kind(path: Path) -> str:
    return "folder" if path.is_dir() else "file"


def _ports_there() -> str:
    from serial.tools import list_ports  # noqa: PLC0415 - only an error needs it

    found = sorted(port.device for port in list_ports.comports())
    return f"there are {', '.join(found)}" if found else "there is none on this machine"


def _advice(name: str, baud: int, error: BaseException) -> str:
    number = _number(error)
    if number == errno.EACCES:
        return f"permission denied: {_group_advice(name)}"
    if number in {errno.EAGAIN, errno.EBUSY}:
        return "another program uses this port: close it first ('fuser' names it)"
    if number in {errno.ENOTTY, errno.EINVAL, errno.EIO}:
        return (
            f"cannot be used as a serial port at {baud} Bd: it is another device, or cannot do that"
        )
    if number == errno.ECONNREFUSED or name.startswith("socket:"):
        return f"nobody answers there ({_why(error)}): check the address and that the device is on"
    return f"cannot be opened: {_why(error)}"


def _number(error: BaseException | None) -> int | None:
    """Return the system's error number, which pyserial's error has or was raised from."""
    while error is not None:
        number = getattr(error, "errno", None) or (error.args[0] if error.args else None)
        if isinstance(number, int):
            return number
        error = error.__context__
    return None


def _group_advice(name: str) -> str:
    try:
        group = grp.getgrgid(Path(name).stat().st_gid).gr_name
    except (KeyError, OSError):
        group = "dialout"
    if group == "root":
        return "only root may use it; set its group to dialout with a udev rule"
    return (
        f"join the group that may use it with 'sudo usermod -aG {group} $USER', "
        "then log out and in again"
    )


def _why(error: BaseException) -> str:
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " ".join(text.split())
