"""Setting up an LMS2xx: what it is, what it keeps in its EEPROM, what it is to do."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, TypeVar

from laserfeatures.drivers.lms import requests
from laserfeatures.drivers.lms.configuration import Configuration
from laserfeatures.drivers.lms.dialog import MODE_CHANGE, TRIES, LmsDialog
from laserfeatures.drivers.lms.measurements import check_variant
from laserfeatures.drivers.lms.ranges import LAYOUTS
from laserfeatures.drivers.lms.status import Status, parse_errors, parse_status
from laserfeatures.drivers.lms.telegrams import pack_request
from laserfeatures.errors import DriverError, ProtocolError

log = logging.getLogger("laserfeatures.drivers")

Content = TypeVar("Content")

WRITING = 7.0  # [s] that a change of the EEPROM may take


@dataclass(kw_only=True, eq=False)
class LmsSetup(LmsDialog):
    """The part of the driver that sets the scanner up; it writes only what differs."""

    angle: Literal[100, 180] | None = None
    resolution: float | None = None
    unit: Literal["mm", "cm"] | None = None
    reach: Literal[8, 16, 32] | None = None
    indices: bool | None = None
    device_type: str = field(init=False, default="")
    status: Status | None = field(init=False, default=None)

    def _identify(self) -> None:
        """Ask the scanner what it is."""
        name = self._request(pack_request(requests.TYPE)).data
        self.device_type = name.decode("ascii", "replace").strip("\0 ")
        if not name.startswith(b"LMS"):
            raise ProtocolError(f"{self.port}: expected an LMS2xx, got {self.device_type!r}")

    def _look_after(self) -> None:
        """Ask the scanner how it is."""
        self.status = self._read_status()
        log.info("%s: %s, serial %s", self.port, self.device_type, self.status.serial)
        if self.status.defective:
            errors = self._read(requests.ERRORS, parse_errors)
            log.warning("%s: the scanner lists: %s", self.port, ", ".join(errors) or "no errors")

    def _read_status(self) -> Status:
        def checked(data: bytes) -> Status:
            status = parse_status(data)
            check_variant(status.angle, status.resolution)
            return status

        return self._read(requests.STATUS, checked)

    def _read(self, command: int, parse: Callable[[bytes], Content]) -> Content:
        """Return what the reply to a request says."""
        data = self._request(pack_request(command)).data
        try:
            return parse(data)
        except ProtocolError as error:
            raise ProtocolError(f"{self.port}: {error}") from error

    def _configure(self) -> None:
        """Write the configuration, if it is not as wanted, and read it again."""
        for _ in range(TRIES):
            present = self._read(requests.READ_CONFIGURATION, Configuration)
            wanted = present.changed(reach=self.reach, unit=self.unit, indices=self.indices)
            if wanted.measuring_mode not in LAYOUTS:
                raise DriverError(
                    f"{self.port}: the scanner is set to measuring mode "
                    f"{wanted.measuring_mode:02X}, which has no ranges: set one with reach=8, 16 "
                    "or 32 [m]"
                )
            if wanted == present:
                return
            self._set_mode(requests.installation_mode(), "the installation mode")
            request = pack_request(requests.WRITE_CONFIGURATION, wanted.data)
            reply = self._try(request, self._answer_time, WRITING)
            self._set_mode(requests.operating_mode(requests.ON_REQUEST), "the monitoring mode")
            if reply is not None and reply.data[:1] != b"\1":
                break
        raise DriverError(
            f"{self.port}: the scanner did not take measuring mode {wanted.measuring_mode:02X}, "
            f"unit {wanted.unit}, indices {wanted.indices}; it stays with "
            f"{present.measuring_mode:02X}, {present.unit}, {present.indices}: leave out reach, "
            "unit and indices, or choose others"
        )

    def _variant(self) -> tuple[int, int]:
        """Return the field of view [degrees] and step [1/100 degree] that are wanted."""
        field_of_view = self.status.angle if self.status else 180
        resolution = self.status.resolution if self.status else 50
        if self.resolution is not None:
            resolution = round(self.resolution * 100)
        if self.angle is not None or resolution == 25:
            field_of_view = self.angle or 100
        if self.angle == 180 and resolution == 25:
            resolution = 50
        return field_of_view, resolution

    def _set_variant(self) -> None:
        """Set field of view and resolution, if they are not as wanted, and read them again."""
        wanted = self._variant()
        for _ in range(TRIES):
            if self.status is not None and wanted == (self.status.angle, self.status.resolution):
                return
            reply = self._try(requests.variant(*wanted), self._answer_time, WRITING)
            if reply is not None and reply.data[:1] != b"\1":
                break
            self.status = self._read_status()
        raise DriverError(
            f"{self.port}: the scanner refuses {wanted[0]} degrees in steps of "
            f"{wanted[1] / 100} degrees: leave out angle and resolution, or choose others"
        )

    def _set_mode(self, request: bytes, name: str) -> None:
        reply = self._request(request, MODE_CHANGE)
        if reply.data[:1] != b"\0":
            raise DriverError(f"{self.port}: the scanner refuses {name}")
