"""Coverage-guided fuzzing of the decoders with atheris (``pip install atheris``).

``python benchmarks/driver_fuzz_guided.py PROTOCOL [--bytes N]`` lets atheris make inputs
that reach ever more of the code, from frames as they are on the line, until so many bytes have gone
through. Each input goes to every pure function, which may raise ProtocolError only, and
in pieces to a decoder, which may raise nothing.
"""

import argparse
import os
import sys
import tempfile
from contextlib import suppress
from functools import partial
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["laserfeatures.drivers"]):
    from laserfeatures.drivers import make_driver
    from laserfeatures.drivers.ld19 import frames as ld19
    from laserfeatures.drivers.lms import configuration, measurements, status, telegrams
    from laserfeatures.drivers.rplidar import packets
    from laserfeatures.drivers.urg import commands, ranges, scip, sensor
    from laserfeatures.drivers.urg import decoder as urg

from driver_fuzz import QUERIES, session, sweeps

from laserfeatures import ProtocolError


def answers(data):
    """Decode the body of every kind of answer of an RPLIDAR."""
    for kind in packets.Answer:
        yield partial(packets.parse_reply, kind, data)


def pure_functions(protocol, data):
    """Return the calls of a protocol's pure functions with `data`."""
    if protocol == "ld19":
        return [lambda: ld19.decode(data), lambda: ld19.decode(ld19.HEAD + data[:45])]
    if protocol == "lms":
        values = telegrams.Telegram
        return [
            lambda: telegrams.parse(data),
            lambda: telegrams.parse_request(data),
            lambda: status.parse_status(data),
            lambda: status.parse_errors(data),
            lambda: configuration.parse_written(data),
            lambda: configuration.Configuration(data),
            lambda: measurements.parse_measurement(values(data[0], data[1:-1], data[-1])),
        ]
    if protocol == "rplidar":
        return [lambda: packets.parse_descriptor(data), *answers(data)]
    return [
        lambda: urg.decode_message(data),
        lambda: urg.decode_scan(data),
        lambda: scip.decode_reply(data),
        lambda: scip.decode_line(data),
        lambda: scip.decode_key_line(data),
        lambda: commands.decode_measurement(data),
        lambda: ranges.decode(data, 3),
        lambda: ranges.decode_time(data),
        lambda: ranges.decode_block(data, len(data) // 3, 3),
        lambda: sensor.decode_fields(data.split(b"\n")),
        lambda: sensor.decode_geometry(data.split(b"\n")),
    ]


class Target:
    """What atheris calls with each input."""

    def __init__(self, protocol, wanted):
        self.protocol, self.wanted, self.done = protocol, wanted, 0
        self.decoder = make_driver(f"{protocol}:none").decoder()
        heard, _ = session(protocol, QUERIES.get(protocol, [""])[0])
        sweeps(self.decoder, heard)  # it knows the device, and waits for scans

    def __call__(self, data):
        """Decode an input."""
        if not data:
            return
        for call in pure_functions(self.protocol, data):
            with suppress(ProtocolError):
                call()
        size = data[0] % 64 + 1
        for start in range(0, len(data), size):
            self.decoder.received(data[start : start + size], self.done / 1000)
        if data[0] & 64:
            self.decoder.sent(data, self.done / 1000)
        self.done += len(data)
        if self.done >= self.wanted:
            print(f"{self.protocol}: {self.done} bytes, {self.decoder.losses.frames} frames: sound")
            sys.stdout.flush()
            os._exit(0)  # to libFuzzer, an exception would be a crash


def corpus(protocol, folder):
    """Write what comes and goes in sessions, one file a piece."""
    for i, query in enumerate(QUERIES.get(protocol, [""])):
        heard, _ = session(protocol, query)
        for j, (_, data, _) in enumerate(heard):
            Path(folder, f"{i}-{j}").write_bytes(data)


def main():
    """Fuzz."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("protocol", choices=["urg", "lms", "rplidar", "ld19"])
    parser.add_argument("--bytes", type=int, default=10_000_000)
    options = parser.parse_args()
    folder = tempfile.mkdtemp()
    corpus(options.protocol, folder)
    arguments = [sys.argv[0], "-max_len=4096", "-seed=1", "-verbosity=0", folder]
    atheris.Setup(arguments, Target(options.protocol, options.bytes))
    atheris.Fuzz()


if __name__ == "__main__":
    main()
