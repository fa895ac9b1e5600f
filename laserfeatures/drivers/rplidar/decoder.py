"""From the conversation with an RPLIDAR to scans and replies."""

from collections.abc import Sequence
from dataclasses import dataclass

from laserfeatures.drivers.decoder import Sweep
from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.rplidar.capsule_turns import LEGACY, CapsuleTurns
from laserfeatures.drivers.rplidar.models import UNKNOWN, Model, model_of
from laserfeatures.drivers.rplidar.node_turns import NodeTurns, Turn
from laserfeatures.drivers.rplidar.packets import (
    ANSWER,
    DESCRIPTOR,
    U32,
    Answer,
    Command,
    Configuration,
    Info,
    Key,
    Reply,
    SampleRate,
    next_request,
    parse_descriptor,
    parse_reply,
)
from laserfeatures.drivers.rplidar.turns import scan_of, share_missing
from laserfeatures.drivers.rplidar.ultra import DENSE, ULTRA
from laserfeatures.errors import ProtocolError

NOT_KNOWN = SampleRate(500e-6, 250e-6)  # of an A1, until the device has told
MOTOR = {Command.MOTOR_PWM, Command.MOTOR_SPEED}
PIECE = 4096  # bytes looked at at once
KINDS = {
    Answer.CAPSULES: LEGACY,
    Answer.ULTRA_CAPSULES: ULTRA,
    Answer.DENSE_CAPSULES: DENSE,
}


@dataclass(frozen=True)
class Started:
    """The device has begun to send measurements in this form."""

    kind: Answer


class RPLidarDecoder:
    """Listens to a conversation.

    Between a request and the next stream bytes that belong to no answer are the rest of an older
    stream, or the banner of a device that starts: not counted as lost.

    Parameters
    ----------
    losses : Losses
        Where it counts what it throws away.
    baud : int or None
        Rate of the line [Bd], for the times; None: that of the model.
    coverage : float
        Least share of a turn that makes a scan; a turn with less is counted as missed.
    min_quality : int
        Below it a measurement is no return.
    """

    def __init__(self, losses: Losses, baud: int | None, coverage: float, min_quality: int) -> None:
        self.losses = losses
        self._given_baud = baud
        self._coverage = coverage
        self._min_quality = min_quality
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._buffer = b""
        self._stream: NodeTurns | CapsuleTurns | None = None
        self._host = b""
        self._set_model(UNKNOWN)
        self._rate = NOT_KNOWN

    def sent(self, data: bytes, _time: float) -> None:
        """Take note of a request: it ends a stream, and any answer that is half received."""
        self._host = (self._host + data)[-PIECE:]
        while found := next_request(self._host):
            command, _, end = found
            self._host = self._host[end:]
            if command not in MOTOR:
                self._buffer, self._stream = b"", None

    def received(self, data: bytes, time: float) -> Sequence[object]:
        """Take bytes of the device; return scans (`Sweep`), `Started` and replies."""
        out: list[object] = []
        if self._stream is None:
            data = self._answers(data, out)
        if self._stream is not None:
            for i in range(0, len(data), PIECE):
                behind = len(data) - i - PIECE
                late = max(behind, 0) * 10 / self._baud
                for turn in self._stream.feed(data[i : i + PIECE], time - late):
                    out += self._sweep(turn, self._stream.delay)
        return out

    def _sweep(self, turn: Turn, delay: float) -> list[Sweep]:
        if share_missing(turn.measured) > 1 - self._coverage:
            self.losses.missed += 1
            return []
        scan = scan_of(turn.measured, self._limits, turn.begin, self._min_quality)
        return [Sweep(scan, turn.begin + delay)]

    def _answers(self, data: bytes, out: list[object]) -> bytes:
        """Take the answers out of the bytes, up to the beginning of a stream; return the rest."""
        buffer = self._buffer + data
        self._buffer = b""
        while (at := buffer.find(ANSWER)) >= 0:
            buffer = buffer[at:]
            try:
                head = parse_descriptor(buffer[:DESCRIPTOR])
            except ProtocolError:
                if len(buffer) < DESCRIPTOR:
                    break
                buffer = buffer[1:]
                continue
            if head.stream:
                self._begin(head.kind)
                out.append(Started(head.kind))
                return buffer[DESCRIPTOR:]
            end = DESCRIPTOR + head.length
            if len(buffer) < end:
                break
            reply = parse_reply(head.kind, buffer[DESCRIPTOR:end])
            self._note(reply)
            out.append(reply)
            buffer = buffer[end:]
        else:
            buffer = buffer[-1:]
        self._buffer = buffer
        return b""

    def _begin(self, kind: Answer) -> None:
        if kind is Answer.NODES:
            period = self._mode_period or self._rate.standard
            self._stream = NodeTurns(period, self._baud, self.losses)
        else:
            period = self._mode_period or self._rate.express
            self._stream = CapsuleTurns(KINDS[kind], period, self._baud, self.losses)

    def _set_model(self, model: Model) -> None:
        self._limits = model.limits
        self._baud = self._given_baud or model.baud
        self._mode_period: float | None = None

    def _note(self, reply: Reply) -> None:
        """Keep what a reply says of limits and times."""
        if isinstance(reply, Info):
            self._set_model(model_of(reply.model))
        elif isinstance(reply, SampleRate) and reply.standard and reply.express:
            self._rate = reply
        elif isinstance(reply, Configuration) and len(reply.value) >= U32.size:
            value = U32.unpack_from(reply.value)[0] / 256
            if reply.key == Key.SAMPLE_TIME and value:
                self._mode_period = value / 1e6
            if reply.key == Key.MAX_DISTANCE and value > self._limits[0]:
                self._limits = (self._limits[0], value)
