import math

import numpy as np
import pytest

from laserfeatures.simulation import (
    Drive,
    Scanner,
    World,
    hallway,
    random_hallway,
    random_office,
    random_room,
    read_plan,
    write_plan,
)


def assert_same(plan, world, drive):
    for name in ("walls", "boxes", "poles", "reflectivity"):
        assert getattr(plan.world, name).tobytes() == getattr(world, name).tobytes(), name
    if drive is None:
        assert plan.drive is None
        return
    assert plan.drive.waypoints.tobytes() == drive.waypoints.tobytes()
    for name in ("scanner", "seed", "speed", "scan_rate"):
        assert getattr(plan.drive, name) == getattr(drive, name), name


@pytest.mark.parametrize("seed", range(20))
def test_a_random_world_comes_back_bit_for_bit(seed, tmp_path):
    office = random_office(seed)
    worlds = [
        (hallway()[0], None),
        (random_room(seed, poles=3)[0], None),
        (random_hallway(seed)[0], None),
        (office.world, office.drive),
    ]
    for world, drive in worlds:
        write_plan(world, tmp_path / "plan.toml", drive)
        assert_same(read_plan(tmp_path / "plan.toml"), world, drive)


def test_any_numbers_come_back_bit_for_bit(tmp_path):
    rng = np.random.default_rng(2)
    boxes = rng.uniform(0.01, 7, (500, 5)) * 10.0 ** rng.integers(-5, 3, (500, 1))
    world = World(boxes=boxes, reflectivity=1 - rng.random(500))
    scanner = Scanner(beams=int(np.int64(7)), range_sigma=np.float64(1e-7), beam_width=1 / 3)
    drive = Drive(waypoints=[(-5e3, -50), (-6e3, -1 / 3)], scanner=scanner, seed=np.int64(3))
    write_plan(world, tmp_path / "plan.toml", drive)
    assert_same(read_plan(tmp_path / "plan.toml"), world, drive)


def test_what_could_not_be_read_again_is_not_written(tmp_path):
    path = tmp_path / "plan.toml"
    with pytest.raises(ValueError, match=r"no plan that can be read again: .*a plan needs"):
        write_plan(World(), path)
    with pytest.raises(ValueError, match=r"no plan that can be read again: .*up to 1000000"):
        write_plan(World(poles=[(1e7, 0, 1)]), path)
    pole = World(poles=[(0, 0, 1)])
    with pytest.raises(ValueError, match=r"way-point 1 at \(0\.5, 0\) is inside pole 0"):
        write_plan(pole, path, Drive(waypoints=[(2, 0), (0.5, 0)]))
    with pytest.raises(ValueError, match=r"no plan that can be read again: .*range_max"):
        write_plan(
            pole, path, Drive(waypoints=[(2, 0), (3, 0)], scanner=Scanner(range_max=math.inf))
        )
    assert not path.exists()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"waypoints": [(0, 0)]}, "waypoints must be at least 2, got 1"),
        ({"waypoints": [(0, 0), (math.nan, 0)]}, "way-point 1 must be finite"),
        ({"waypoints": [(0, 0), (1, 0), (1, 0)]}, "way-points 1 and 2 must differ"),
        ({"seed": -1}, "seed must be >= 0, got -1"),
        ({"speed": 0.0}, r"speed must be > 0 m/s, got 0\.0"),
        ({"scan_rate": math.nan}, "scan_rate must be > 0 Hz, got nan"),
    ],
)
def test_a_drive_that_makes_no_sense_is_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        Drive(**{"waypoints": [(0, 0), (1, 0)], **parameters})
