"""Playing an emulated device on a pseudo-terminal or a TCP port."""

import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Self

from laserfeatures.emulators.device import Device
from laserfeatures.emulators.line_ends import End, Pty, Tcp
from laserfeatures.errors import DriverError

LONGEST_SLEEP = 0.05  # [s]; how soon a link notices that it is to end


class Emulator:
    """Plays a device in a thread of its own.

    Parameters
    ----------
    device : Device
        What is played.
    link : str or Path, optional
        Name of a symbolic link to its pseudo-terminal.
    tcp : int, optional
        TCP port to listen on instead of a pseudo-terminal; 0: any free one.
    speed : float
        How many times faster than a real device it lives.
    patient : bool
        Whether it waits for a host that reads too slowly; a real device drops what does not fit.

    Examples
    --------
    ``with Emulator(device) as emulator: ...`` and a host opens ``emulator.port``.
    """

    def __init__(
        self,
        device: Device,
        *,
        link: str | Path | None = None,
        tcp: int | None = None,
        speed: float = 1.0,
        patient: bool = False,
    ) -> None:
        self.device = device
        self._patient = patient
        self.speed = speed
        self._link, self._tcp = link, tcp
        self._end: End | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=device.name, daemon=True)
        self.error: BaseException | None = None

    @property
    def port(self) -> str:
        """What a host opens.

        Raises
        ------
        DriverError
            If it is unplugged.
        """
        if self._end is None:
            raise DriverError(f"the emulated {self.device.name} is not plugged in")
        return self._end.name

    @property
    def dropped(self) -> int:
        """Bytes lost so far because the host did not read them."""
        return 0 if self._end is None else self._end.dropped

    def __enter__(self) -> Self:
        """Plug it in and power it on."""
        self._end = self._plug()
        self._started = time.monotonic()
        self.device.power_on(0.0)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Unplug it."""
        self._stopping.set()
        self._thread.join()
        if self._end:
            self._end.close()
        if self.error and kind is None:
            raise self.error

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                self._step()
        except BaseException as error:  # noqa: BLE001 - whoever leaves the block gets it
            self.error = error

    def _step(self) -> None:
        if self._end is None:
            raise DriverError("the emulator is not plugged in")
        end, device, now = self._end, self.device, self._now()
        out = device.take(now, end.host_baud())
        if out:
            end.write(out)
        if device.faults.unplugged:
            self._replug()
            return
        sleep = (device.due(now) - self._now()) / self.speed
        heard = end.read(min(max(sleep, 0.0), LONGEST_SLEEP))
        if heard:
            device.give(heard, self._now(), end.host_baud())

    def _replug(self) -> None:
        """Unplug, wait, and plug in again: a USB device has lost its power, too."""
        if self._end is not None:
            self._end.close()
        self.device.faults.unplugged = False
        self.device.hush()
        self._stopping.wait(self.device.faults.unplugged_time)
        self._end = self._plug()
        self.device.power_on(self._now())

    def _plug(self) -> End:
        if self._tcp is None:
            return Pty(self._link, patient=self._patient)
        end = Tcp(self._tcp)
        self._tcp = end.number  # the same when it is plugged in again
        return end

    def _now(self) -> float:
        return (time.monotonic() - self._started) * self.speed
