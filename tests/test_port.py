"""Ports: what is said when one cannot be used."""

import errno
import os
import pty

import pytest

from laserfeatures import DeviceLostError, DriverError
from laserfeatures.drivers import port as port_module
from laserfeatures.drivers.port import Port


@pytest.fixture
def terminal():
    master, slave = pty.openpty()
    yield master, os.ttyname(slave)
    os.close(slave)
    os.close(master)


def test_bytes_go_both_ways(terminal):
    master, name = terminal
    port = Port(name, 115_200)
    port.write(b"\x00\xff\r\n")
    assert os.read(master, 10) == b"\x00\xff\r\n"
    os.write(master, b"\n\r\x11\x13")
    assert port.read(1.0) == b"\n\r\x11\x13"
    assert port.read(0.01) == b""
    port.close()


def test_loop_is_a_port_too():
    port = Port("loop://", 9600)
    port.write(b"abc")
    assert port.read(0.1) == b"abc"
    assert port.read(0.01) == b""
    port.close()


def test_the_rate_can_be_changed(terminal):
    port = Port(terminal[1], 9600)
    port.baud = 500_000
    assert port.baud == 500_000
    with pytest.raises(DriverError, match="cannot be set to -5 Bd"):
        port.baud = -5
    port.close()


def test_a_terminal_without_modem_lines_is_no_error(terminal):
    port = Port(terminal[1], 9600)
    assert port.set_dtr(False) is False
    port.close()


def test_a_closed_other_end_is_a_lost_device():
    master, slave = pty.openpty()
    port = Port(os.ttyname(slave), 9600)
    os.close(slave)
    os.close(master)
    with pytest.raises(DeviceLostError, match="the device is gone"):
        port.read(1.0)
    with pytest.raises(DeviceLostError):
        port.write(b"x")
    port.close()


def test_there_is_no_such_port():
    with pytest.raises(DriverError, match=r"/dev/no_such: there is no such port; there (is|are) "):
        Port("/dev/no_such", 9600)


def test_a_file_is_no_port(tmp_path):
    with pytest.raises(DriverError, match="expected a serial port, got a folder"):
        Port(str(tmp_path), 9600)
    (tmp_path / "file").touch()
    with pytest.raises(DriverError, match="expected a serial port, got a file"):
        Port(str(tmp_path / "file"), 9600)


def test_another_device_file_is_no_serial_port():
    with pytest.raises(DriverError, match="cannot be used as a serial port at 9600 Bd"):
        Port("/dev/null", 9600)


def test_a_busy_port_is_said(terminal):
    port = Port(terminal[1], 9600)
    with pytest.raises(DriverError, match="another program uses this port: close it first"):
        Port(terminal[1], 9600)
    port.close()


def test_nobody_listens():
    with pytest.raises(DriverError, match="nobody answers there"):
        Port("socket://127.0.0.1:1", 9600)


def test_permission_is_asked_of_the_ports_own_group(monkeypatch):
    """Root may open anything, so the refusal is played."""
    denied = OSError(errno.EACCES, "Permission denied")
    text = port_module._advice("/dev/null", 9600, denied)
    assert text.startswith("permission denied: ")
    monkeypatch.setattr(port_module.grp, "getgrgid", lambda _: type("", (), {"gr_name": "dialout"}))
    text = port_module._advice("/dev/null", 9600, denied)
    assert "'sudo usermod -aG dialout $USER', then log out and in again" in text
