"""Turning the motor of an RPLIDAR on and off."""

from laserfeatures.drivers.reader import Reader
from laserfeatures.drivers.rplidar.packets import U16, Command, request

LARGEST_DUTY = 1023
USUAL_SPEED = 600  # [1/min]
FIRST_BY_SPEED = 6  # series from S on turn at a given speed
FIRST_BY_PWM = 2  # series from A2 on may have an accessory board


class Motor:
    """The motor, by whichever way the device has.

    Parameters
    ----------
    reader : Reader
        The open port.
    duty : int
        Duty of the pulse-width modulation, 0 .. 1023.
    """

    def __init__(self, reader: Reader, duty: int) -> None:
        self._reader = reader
        self._duty = duty
        self._by_line = False
        self._command: Command | None = None

    def line_on(self) -> None:
        """Release DTR, which opening a port sets: on an A1's adapter a set DTR stops the motor."""
        self._by_line = self._reader.port.set_dtr(False)

    def on(self, command: Command) -> None:
        """Turn it on by a request: `MOTOR_PWM` or `MOTOR_SPEED`."""
        self._command = command
        value = self._duty if command is Command.MOTOR_PWM else USUAL_SPEED
        self._reader.write(request(command, U16.pack(value)))

    def off(self) -> None:
        """Turn it off in each way that it was turned on."""
        if self._command is not None:
            self._reader.write(request(self._command, U16.pack(0)))
        if self._by_line:
            self._reader.port.set_dtr(True)
