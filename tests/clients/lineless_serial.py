"""Makes pyserial accept a port without modem lines, such as a pseudo-terminal.

Clients set DTR for the motor of an A1; on a pseudo-terminal that fails with ENOTTY, as it does on
some cheap adapters. Nothing else is changed. Import it before the client.
"""

import errno

import serial

MISSING = {errno.ENOTTY, errno.EINVAL}


class LinelessSerial(serial.Serial):
    """A serial port whose DTR and RTS may be missing."""

    def _update_dtr_state(self):
        self._try(super()._update_dtr_state)

    def _update_rts_state(self):
        self._try(super()._update_rts_state)

    @staticmethod
    def _try(update):
        try:
            update()
        except OSError as error:
            if error.errno not in MISSING:
                raise


serial.Serial = LinelessSerial
