"""SICK LMS200, LMS211, LMS220, LMS221 and LMS291 (type 6) on RS-232 or RS-422."""

from laserfeatures.drivers.lms.configuration import Configuration, parse_written
from laserfeatures.drivers.lms.decoder import LmsDecoder
from laserfeatures.drivers.lms.driver import Lms
from laserfeatures.drivers.lms.measurements import Measurement, parse_measurement
from laserfeatures.drivers.lms.status import Status, parse_errors, parse_status
from laserfeatures.drivers.lms.telegrams import Telegram, pack, pack_request, parse, parse_request

__all__ = [
    "Configuration",
    "Lms",
    "LmsDecoder",
    "Measurement",
    "Status",
    "Telegram",
    "pack",
    "pack_request",
    "parse",
    "parse_errors",
    "parse_measurement",
    "parse_request",
    "parse_status",
    "parse_written",
]
