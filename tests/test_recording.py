"""What is recorded is played again, to the last bit, whatever happened."""

import base64
import gzip
import itertools
import json
import os
import time
from contextlib import suppress
from random import Random

import pytest
from played import address, ld19, record, same

import laserfeatures as lf
from laserfeatures.drivers import make_driver, recorder
from laserfeatures.drivers.host_clock import now
from laserfeatures.drivers.recorder import Recorder
from laserfeatures.emulators import Emulator, Faults, WorldFeed
from laserfeatures.emulators.devices import DEVICES, device_class
from laserfeatures.growing_file import GrowingFile
from laserfeatures.simulation import hallway
from laserfeatures.sources.log import Log
from laserfeatures.sources.recording import read_recording

DAMAGE = {"bit_flip": 0.01, "lost_byte": 0.01, "garbage": 0.01, "cut": 0.01}


@pytest.fixture(scope="module")
def damaged(tmp_path_factory):
    """Return a recording of a bad line, its scans with their arrivals, and the losses."""
    path = tmp_path_factory.mktemp("recording") / "bad.rec"
    with ld19(DAMAGE) as emulator:
        return path, *record(path, address(emulator), 8)


def lines_of(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def played(path, **options):
    with lf.open_source(path, **options) as source:
        return list(source), source


def test_the_replay_gives_the_live_scans_also_of_a_bad_line(damaged):
    path, live, losses = damaged
    scans, source = played(path)
    assert source.format == "recording"
    assert len(scans) >= len(live)  # what the host had not fetched yet is there, too
    assert all(same(a, b) for a, (b, _) in zip(scans, live, strict=False))
    assert source.skipped == losses.damaged > 0
    assert source.first_error.startswith(f"{path}:")
    assert "an LD19 frame must" in source.first_error


@pytest.mark.parametrize("protocol", DEVICES)
def test_every_protocol_s_replay_gives_the_live_scans(protocol, tmp_path):
    world, path = hallway()
    device = device_class(protocol)(WorldFeed(world, path[0]), Faults({"bit_flip": 0.02}))
    with Emulator(device) as emulator:
        port = f"{protocol}:{emulator.port}"
        live, _ = record(tmp_path / "run.rec", port, 5)
        with pytest.raises(lf.DriverError, match="no-such-port"):
            record(tmp_path / "none.rec", f"{protocol}:///dev/no-such-port", 1)
    scans, _ = played(tmp_path / "run.rec")
    assert len(scans) >= 5
    assert all(same(a, b) for a, (b, _) in zip(scans, live, strict=False))


def test_a_rate_that_was_found_by_trying_needs_no_record(tmp_path):
    world, path = hallway()
    device = device_class("rplidar")(WorldFeed(world, path[0]), model="A3")
    assert device.baud == 256_000
    with Emulator(device) as emulator:
        live, _ = record(tmp_path / "run.rec", f"rplidar:{emulator.port}", 3)
    scans, _ = played(tmp_path / "run.rec")
    assert all(same(a, b) for a, (b, _) in zip(scans, live, strict=False))


def test_the_scans_lie_beside_the_bytes(damaged):
    path, live, losses = damaged
    lines = lines_of(path)
    assert lines[0]["protocol"] == "ld19"
    assert lines[0]["settings"]["buffer"] == 64
    beside = [line["scan"] for line in lines if "scan" in line]
    assert [scan["stamp"] for scan in beside] == [scan.stamp for scan, _ in live]
    assert [scan["arrival"] for scan in beside] == [arrival for _, arrival in live]
    for written, (scan, _) in zip(beside, live, strict=True):
        assert written["angles"] == scan.angles.tolist()  # an LD19's differ from turn to turn
        assert written["ranges"] == [r if r == r else None for r in scan.ranges.tolist()]  # noqa: PLR0124 - nan
    assert lines[1]["open"] is True
    assert lines[-2]["losses"]["damaged"] == losses.damaged
    assert lines[-1]["end"] is True
    times = [line["t"] for line in lines[1:] if "rx" in line or "open" in line]
    assert times == sorted(times)


def test_the_replay_gives_the_live_scans_across_a_reconnect(tmp_path):
    path = tmp_path / "unplugged.rec"
    with ld19(link=tmp_path / "port") as emulator:

        def unplug(scans):
            if scans == 3:
                emulator.device.faults.unplugged = True

        live, losses = record(path, address(emulator), 6, after=unplug, reconnect=True)
    assert losses.reconnects == 1
    assert sum("open" in line for line in lines_of(path)) >= 2
    scans, _ = played(path)
    assert all(same(a, b) for a, (b, _) in zip(scans, live, strict=False))


def test_nothing_is_left_of_what_came_before_the_port_was_opened_anew(damaged, tmp_path):
    header, *rest = damaged[0].read_text().splitlines(keepends=True)
    time = json.loads(rest[0])["t"] - 1
    half = base64.b64encode(b"\x54\x2c" + bytes(20)).decode()
    before = [{"t": time, "open": True}, {"t": time, "rx": half}]
    text = header + "".join(json.dumps(line) + "\n" for line in before) + "".join(rest)
    (tmp_path / "twice.rec").write_text(text)
    twice, once = (
        played(f"replay:{path}?speed=1000")[1].losses
        for path in (tmp_path / "twice.rec", damaged[0])
    )
    assert twice == once


def test_it_may_be_packed(damaged, tmp_path):
    path, live, _ = damaged
    (tmp_path / "run.rec.gz").write_bytes(gzip.compress(path.read_bytes()))
    scans, source = played(tmp_path / "run.rec.gz", range_max=2.0)
    assert source.format == "recording"
    assert len(scans) >= len(live)
    assert scans[0].range_max == 2.0


@pytest.mark.parametrize("lost", [0, 1, 17])
def test_what_was_written_before_a_loss_of_power_is_read(damaged, tmp_path, lost):
    path, live, losses = damaged
    whole = path.read_bytes()
    (tmp_path / "cut.rec").write_bytes(whole[: whole.rstrip().rindex(b"\n") - lost])
    scans, source = played(tmp_path / "cut.rec")
    assert all(same(a, b) for a, (b, _) in zip(scans, live, strict=False))
    assert len(scans) >= len(live)
    assert source.skipped == losses.damaged + (lost > 0)  # a line without its end is whole
    (tmp_path / "zeros.rec").write_bytes(whole + bytes(4096))  # as some file systems leave it
    assert len(played(tmp_path / "zeros.rec")[0]) == len(scans)


def test_a_broken_line_is_named_or_skipped(damaged, tmp_path):
    path = tmp_path / "broken.rec"
    lines = damaged[0].read_bytes().splitlines(keepends=True)
    number = next(i for i, line in enumerate(lines) if b'"rx"' in line) + 1
    for bad in (
        b'{"t": 1, "rx": "?"}\n',
        b"{}\n",
        b'{"t": NaN, "open": true}\n',
        b"7\n",
        b"\0\xff\n",
    ):
        path.write_bytes(b"".join([*lines[: number - 1], bad, *lines[number:]]))
        with pytest.raises(lf.SourceError, match=rf"broken.rec:{number}: expected a JSON object"):
            played(path)
        scans, source = played(path, on_error="skip")
        assert source.first_error.startswith(f"{path}:{number}: expected a JSON object")
        assert len(scans) >= len(damaged[1]) - 1


def test_noise_in_a_recording_is_no_other_error_than_a_source_s(damaged, tmp_path):
    random = Random(7)  # noqa: S311 - for a test
    head, *lines = damaged[0].read_bytes().splitlines(keepends=True)
    text = b"".join(line for line in lines if b'"scan"' not in line)[:20_000]
    for _ in range(300):
        i, size = random.randrange(len(text)), random.choice([1, 1, 5, 300])
        noise = random.choice([random.randbytes(size), b"9" * size, b"[" * 20_000, b"\n" * size])
        (tmp_path / "noisy.rec").write_bytes(head + text[:i] + noise + text[i + size :])
        for on_error in ("skip", "raise"):
            with suppress(lf.SourceError):
                played(tmp_path / "noisy.rec", on_error=on_error)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"version": 2}, "version 2"),
        ({"protocol": "gru"}, "there is no driver 'gru'"),
        ({"settings": {"skip_": 1}}, "skip_"),
        ({"settings": {"buffer": 0}}, "buffer must be >= 1"),
        ({"settings": None}, "expected a header"),
    ],
)
def test_a_header_that_makes_no_sense(tmp_path, change, complaint):
    head = {"laserfeatures": "recording", "version": 1, "protocol": "ld19", "settings": {}}
    (tmp_path / "x.rec").write_text(json.dumps(head | change) + "\n")
    for name in (str(tmp_path / "x.rec"), f"replay:{tmp_path / 'x.rec'}"):
        with pytest.raises(lf.SourceError, match=complaint) as error:
            lf.open_source(name, on_error="skip")
        assert f"{tmp_path / 'x.rec'}:1: " in str(error.value)
        assert "\n" not in str(error.value)


def test_a_replay_keeps_the_time(damaged):
    path, live, _ = damaged
    with lf.open_source(f"replay:{path}?speed=4&scans={len(live)}") as source:
        assert (source.format, source.path) == ("ld19", path)
        began, seen = time.monotonic(), []
        for scan in source:
            seen.append((scan, time.monotonic() - began))
            assert 0 < now() - source.arrival < 0.2
    assert all(same(a, b) for (a, _), (b, _) in zip(seen, live, strict=True))
    took = (live[-1][1] - live[0][1]) / 4
    assert seen[-1][1] - seen[0][1] == pytest.approx(took, abs=0.1)
    assert source.skipped > 0


@pytest.mark.parametrize(
    ("address_", "complaint"),
    [
        ("replay:", "expected replay:FILE"),
        ("replay:x?sped=1", "expected replay:FILE with speed, scans, seconds after"),
        ("replay:x?speed=0", "speed must be > 0, got 0"),
        ("replay:x?speed=fast", "speed must be a number, got 'fast'"),
        ("replay:/no/such/file", "/no/such/file: cannot be opened: No such file"),
        ("replay:/dev/null", "got no header"),
    ],
)
def test_addresses_of_replays_that_make_no_sense(address_, complaint):
    with pytest.raises(lf.SourceError, match=complaint):
        lf.open_source(address_)


def test_a_recording_does_not_replace_a_file_unless_told_so(tmp_path):
    path = tmp_path / "run.rec"
    path.write_text("precious")
    with pytest.raises(FileExistsError, match="is there already"):
        GrowingFile(path)
    driver = make_driver("ld19:///dev/no-such-port")
    with (
        pytest.raises(lf.DriverError),
        GrowingFile(path, replace=True) as file,
        Recorder(file, driver),
        driver,
    ):
        pass
    assert path.read_text() == "precious"  # nothing came in its place
    with GrowingFile(path, replace=True) as file:
        file.write(b"new\n")
        file.write(b"lines\n")
    assert path.read_text() == "new\nlines\n"


def test_a_device_that_says_nothing_leaves_no_file(tmp_path):
    path = tmp_path / "silent.rec"
    with ld19({"stuck": 1.0}) as emulator, pytest.raises(lf.DriverTimeoutError):
        record(path, address(emulator), 1)
    assert not path.exists()


def test_a_full_disk_is_told():
    with ld19() as emulator, pytest.raises(OSError, match="No space left") as error:
        record("/dev/full", address(emulator), 50)
    assert error.value.filename == "/dev/full"


def test_it_is_on_the_disk_each_second(tmp_path, monkeypatch):
    assert recorder.SYNC <= 1.0
    monkeypatch.setattr(recorder, "SYNC", 0.2)
    synced = []
    monkeypatch.setattr(os, "fsync", lambda _descriptor: synced.append(now()))
    with ld19() as emulator:
        record(tmp_path / "run.rec", address(emulator), 9)
    assert len(synced) >= 3
    assert max(b - a for a, b in itertools.pairwise(synced)) < 0.4


@pytest.mark.parametrize("empty", ["true", '""'])
def test_a_recording_of_an_opening_that_was_refused_is_read(tmp_path, empty):
    path = tmp_path / "refused.rec"
    head = '{"laserfeatures": "recording", "version": 1, "protocol": "ld19", "settings": {}}'
    lines = [head, '{"t": 1.0, "open": true}', '{"t": 1.1, "rx": "+tEA"}']
    end = '{"t": 2, "end": true, "error": "p: expected the frames of an LD06, got silence"}'
    path.write_text("\n".join([*lines, f'{{"t": 1.2, "tx": {empty}}}', end]))
    with pytest.raises(lf.SourceError, match="no scan is in it, for it ended with: p: exp"):
        played(path)


@pytest.mark.parametrize("baud", [115_200, 230_400, None])
def test_a_recording_at_the_rate_of_other_models_says_so(tmp_path, baud):
    path = tmp_path / "slow.rec"
    head = {"laserfeatures": "recording", "version": 1, "protocol": "ld19"}
    lines = [head | {"settings": {"baud": baud}}, {"t": 1.0, "end": True}]
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    log = Log(path)
    assert list(read_recording(log)) == []
    assert any("LD14" in text for text in log.notices.values()) == (baud == 115_200)
