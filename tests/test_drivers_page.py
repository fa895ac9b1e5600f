"""The drivers' page names what there is."""

import inspect
import re
from dataclasses import fields
from pathlib import Path

import pytest

from laserfeatures.cli.emulated_device import MET
from laserfeatures.drivers import DRIVERS
from laserfeatures.drivers.address import driver_class
from laserfeatures.drivers.driver import Driver
from laserfeatures.emulators import FAULTS
from laserfeatures.emulators.devices import device_class

PAGE = (Path(__file__).parents[1] / "docs/drivers.md").read_text()
COMMON = {field.name for field in fields(Driver)}


def rows(protocol):
    return [line for line in PAGE.splitlines() if line.startswith(f"| `{protocol}` |")]


@pytest.mark.parametrize("protocol", list(DRIVERS))
def test_the_page_names_every_parameter_of_a_driver(protocol):
    own = {field.name for field in fields(driver_class(protocol)) if field.init} - COMMON
    named = set(re.findall(r"`(\w+)`", rows(protocol)[0].split("|")[3]))
    assert named == own
    doc = inspect.getdoc(driver_class(protocol))
    for name in own:
        assert re.search(rf"^(\w+, )*{name}(, \w+)* : ", doc, re.MULTILINE), name


def test_the_page_names_every_fault():
    first = "".join(line.split("|")[1] for line in PAGE.splitlines() if line.startswith("| `"))
    named = set(re.findall(r"`(\w+)`", first))
    assert named >= {*FAULTS, *MET}


@pytest.mark.parametrize("protocol", list(DRIVERS))
def test_the_faults_of_a_device_are_its_own(protocol):
    known = inspect.signature(device_class(protocol).__init__).parameters
    doc = inspect.getdoc(device_class(protocol))
    for name in re.findall(r"`(\w+)(?:=N)?`", rows(protocol)[1].split("|")[4]):
        assert name in known or f'"{name}"' in doc or name in doc, name
