"""The device's end of a line: a pseudo-terminal or a TCP port."""

import fcntl
import os
import select
import socket
import struct
import tty
from pathlib import Path
from typing import Protocol

from laserfeatures.errors import DriverError

READ = 4096
WRITABLE = 1.0  # [s]
TCGETS2, TERMIOS2 = 0x802C542A, struct.Struct("=4IB19s2I")  # Linux: holds any rate as a number


class End(Protocol):
    """The device's end of a line.

    Attributes
    ----------
    dropped : int
        Bytes lost because the host did not read.
    """

    dropped: int

    @property
    def name(self) -> str:
        """What a host opens."""

    def read(self, timeout: float) -> bytes:
        """Return what the host sent, b"" after `timeout` [s]."""

    def write(self, data: bytes) -> None:
        """Send; what does not fit is lost, as on a real line."""

    def host_baud(self) -> int | None:
        """Return the rate that the host has set, None where that has no meaning."""

    def close(self) -> None:
        """Unplug."""


class Pty:
    """A pseudo-terminal, and a link to it with a name that stays.

    Parameters
    ----------
    link : str or Path, optional
        Name of a symbolic link to make.
    patient : bool
        Whether to wait for a host that reads too slowly, which no real device does.

    Raises
    ------
    DriverError
        If the link cannot be made, or a file of that name is something else.
    """

    def __init__(self, link: str | Path | None = None, *, patient: bool = False) -> None:
        self._link = Path(link) if link else None
        self._patient = patient
        self.dropped = 0
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)  # before the first byte: else echo and newlines garble it
        os.set_blocking(self._master, False)
        self._path = os.ttyname(self._slave)
        if self._link:
            try:
                _point(self._link, self._path)
            except DriverError:
                self.close()
                raise

    @property
    def name(self) -> str:
        """The link, or else the terminal's own path."""
        return str(self._link or self._path)

    def read(self, timeout: float) -> bytes:
        """Return what the host sent."""
        if not select.select([self._master], [], [], timeout)[0]:
            return b""
        try:
            return os.read(self._master, READ)
        except OSError:  # nobody has the other end open
            return b""

    def write(self, data: bytes) -> None:
        """Send; what the terminal's buffer cannot hold is lost, unless the line is `patient`."""
        while data:
            try:
                data = data[os.write(self._master, data) :]
            except BlockingIOError:
                if self._patient and select.select([], [self._master], [], WRITABLE)[1]:
                    continue
                self.dropped += len(data)  # nobody reads: a real device drops it, too
                return

    def host_baud(self) -> int | None:
        """Return the rate that is set on the terminal."""
        state = fcntl.ioctl(self._slave, TCGETS2, bytes(TERMIOS2.size))
        return int(TERMIOS2.unpack(state)[-1])

    def close(self) -> None:
        """Unplug: the host's reads fail."""
        if self._link and self._link.is_symlink() and self._link.readlink() == Path(self._path):
            self._link.unlink()
        os.close(self._slave)
        os.close(self._master)


class Tcp:
    """A TCP port on this machine, for one host at a time.

    Attributes
    ----------
    number : int
        The port's number.
    """

    def __init__(self, port: int = 0, host: str = "127.0.0.1") -> None:
        self._server = socket.create_server((host, port))
        self._client: socket.socket | None = None
        self.number: int = self._server.getsockname()[1]
        self.dropped = 0

    @property
    def name(self) -> str:
        """What pyserial opens."""
        return f"socket://{self._server.getsockname()[0]}:{self.number}"

    def read(self, timeout: float) -> bytes:
        """Return what the host sent; take the next host if there is none."""
        watched = [self._client or self._server]
        if not select.select(watched, [], [], timeout)[0]:
            return b""
        if self._client is None:
            self._client, _ = self._server.accept()
            self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return b""
        try:
            data = self._client.recv(READ)
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        return data

    def write(self, data: bytes) -> None:
        """Send, if a host is there."""
        if self._client is not None:
            try:
                self._client.sendall(data)
            except OSError:
                self._hang_up()

    def host_baud(self) -> int | None:
        """Return None: a network has no baud rate."""
        return None

    def close(self) -> None:
        """Hang up."""
        self._hang_up()
        self._server.close()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = None


def _point(link: Path, target: str) -> None:
    """Point a symbolic link to a terminal, in one step."""
    if link.exists() and not link.is_symlink():
        raise DriverError(f"{link}: expected a name for a link to make, got an existing file")
    aside = link.with_name(f".{link.name}.{os.getpid()}")
    try:
        aside.symlink_to(target)
        aside.replace(link)
    except OSError as error:
        raise DriverError(f"{link}: cannot be made: {error.strerror}") from error
