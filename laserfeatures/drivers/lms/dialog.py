"""Asking an LMS2xx: requests that it may miss, and a line whose rate is not known."""

import logging
import time
from dataclasses import dataclass, field

from laserfeatures.drivers.driver import Driver
from laserfeatures.drivers.host_clock import now
from laserfeatures.drivers.lms import requests
from laserfeatures.drivers.lms.telegrams import Answer, Message, Telegram
from laserfeatures.errors import DriverError

log = logging.getLogger("laserfeatures.drivers")

BITS = 10  # on the wire for a byte
BYTE_GAP = (
    60e-6  # [s]; at least 55 µs belong between two bytes, which slow lines bring by themselves
)
SLOW = 100_000  # [Bd]
ANSWER_TIME = 0.06  # [s]; from a request to its 06
AFTER_REFUSAL = 0.03  # [s]; before a request is repeated that came with a wrong checksum
LATENCY = 0.1  # [s] of the port, the system and this program
FLUSH = 0.02  # [s]; a silence that ends half a request for the scanner: 6 ms and some
MODE_CHANGE = 3.0  # [s]
REPLY = 0.5  # [s]
USUAL_REPLY = 1.0  # [s]; the longest that a real scanner took to change its mode was 0.6
STOPPING = 0.45  # [s] more than else for the answer of a scanner that streams
STATUS_SIZE = 160  # bytes of the longest reply that carries no values
TRIES = 5
BAUD_TRIES = 2
ROUNDS = (0.0, 0.2, 0.6)  # [s] more patience in each round through the rates
SHORT_EXCHANGE = 36  # bytes of a request for a mode, its 06 and its reply, with a reserve
START_UP = 60.0  # [s] that a scanner may take after power-on
AT_POWER_ON = 9600  # [Bd], unless another rate was stored
BAUD_CHANGE = 0.05  # [s]; works at once on real scanners after 20 ms


@dataclass(kw_only=True, eq=False)
class LmsDialog(Driver):
    """The part of the driver that finds the scanner and talks to it."""

    power_on_timeout: float = 0.0
    _baud_before: int | None = field(init=False, default=None, repr=False)
    _known: bool = field(init=False, default=False, repr=False)

    def _request(self, request: bytes, timeout: float = REPLY) -> Telegram:
        """Send a request until it is answered, and return the reply.

        Raises
        ------
        DriverError
            If the scanner refuses it.
        DriverTimeoutError
            If no reply comes.
        """
        wanted = requests.reply_to(request)
        sending = STATUS_SIZE * BITS / self.reader.port.baud
        for attempt in range(TRIES):
            wait = timeout if attempt else min(timeout, USUAL_REPLY)
            reply = self._try(request, self._answer_time, wait + sending)
            if reply is None:
                continue
            self._known = True
            if reply.command == wanted:
                return reply
            self.losses.refusals += 1
            raise DriverError(
                f"{self.port}: the scanner refuses the request {request[4:-2].hex(' ')} "
                f"in its present state or as a device of its type (status {reply.status:02X})"
            )
        raise self._no_answer(f"a SICK LMS2xx's reply {wanted:02X}")

    @property
    def _answer_time(self) -> float:
        """How long the answer to a request may take at the present rate [s]."""
        return ANSWER_TIME + LATENCY + SHORT_EXCHANGE * BITS / self.reader.port.baud

    @property
    def _gap(self) -> float:
        """The pause between the bytes of a request [s]."""
        return BYTE_GAP if self.reader.port.baud > SLOW else 0.0

    def _try(self, request: bytes, answer_time: float, timeout: float) -> Telegram | None:
        """Send a request once; return its reply or refusal, None if nothing comes in time."""
        wanted = requests.reply_to(request)

        def reply(message: object) -> Telegram | None:
            if isinstance(message, Telegram) and message.command in {wanted, requests.REFUSED}:
                return message
            return None

        def first(message: object) -> Message | None:
            return message if isinstance(message, Answer) else reply(message)

        answer = self._ask(request, first, answer_time, tries=1, gap=self._gap)
        if isinstance(answer, Answer) and answer.good:
            return self.reader.reply(reply, timeout)
        if isinstance(answer, Answer):
            time.sleep(AFTER_REFUSAL)
        return answer if isinstance(answer, Telegram) else None

    def _find(self) -> None:
        """Find the scanner's rate, whatever it is doing; it then is quiet, in monitoring mode.

        Raises
        ------
        DriverTimeoutError
            If it is silent at every rate.
        ProtocolError
            If something else answers.
        """
        deadline = now() + self.power_on_timeout
        if self._known:  # it has lost its power, or was reset
            deadline = max(deadline, self.reader.last_heard + START_UP)
        rates = list(dict.fromkeys([self.reader.port.baud, AT_POWER_ON, *requests.BAUDS]))
        round_ = 0
        while round_ < len(ROUNDS) or now() < deadline:
            for rate in rates:
                if self._answers_at(rate, ROUNDS[min(round_, len(ROUNDS) - 1)]):
                    return
            if round_ == len(ROUNDS) - 1 and now() < deadline:
                log.info("%s: no scanner answers yet: it may still be starting", self.port)
            round_ += 1
        raise self._no_answer(
            "a SICK LMS2xx at 9600, 19200, 38400 or 500000 Bd (one just switched on needs up to "
            "60 s: power_on_timeout=60 waits for it)"
        )

    def _answers_at(self, rate: int, patience: float) -> bool:
        """Return whether a scanner answers at a rate; it then has stopped sending values."""
        self.reader.port.baud = rate
        time.sleep(FLUSH)
        request = requests.operating_mode(requests.ON_REQUEST)
        reply = self._try(request, self._answer_time + patience, REPLY + patience)
        if reply is None:
            return False
        self._known = True
        if self._baud_before is None:
            self._baud_before = rate
        return True

    def _is_stopped(self) -> bool:
        """Stop the scans at the present rate, and return whether the scanner has agreed."""
        rate = self.reader.port.baud
        return any(self._answers_at(rate, STOPPING) for _ in range(TRIES))

    def _change_baud(self, rate: int) -> None:
        """Change the rate of scanner and port, until the scanner is switched off.

        Raises
        ------
        DriverError
            If the port cannot have this rate, or the scanner refuses it.
        """
        for _ in range(BAUD_TRIES):
            if not self._switch_baud(rate):
                return
            time.sleep(BAUD_CHANGE)
            if not self._answers_at(rate, ROUNDS[1]):
                self._find()
        if self.reader.port.baud != rate:
            raise DriverError(
                f"{self.port}: the scanner does not answer at {rate} Bd, but at "
                f"{self.reader.port.baud} Bd: check that port and cable are made for that rate "
                "(500000 Bd needs RS-422)"
            )

    def _switch_baud(self, rate: int) -> bool:
        """Change the rate of scanner and port; return whether it was another."""
        port = self.reader.port
        present = port.baud
        if rate == present:
            return False
        port.baud = rate  # if the port cannot, this raises before the scanner has changed
        port.baud = present
        reply = self._request(requests.session_baud(rate), MODE_CHANGE)
        if reply.data[:1] != b"\0":
            raise DriverError(f"{self.port}: the scanner refuses {rate} Bd")
        port.baud = rate
        return True
