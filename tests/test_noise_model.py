import copy
import functools
import math
import pickle
from dataclasses import dataclass, replace

import numpy as np
import pytest
from recordings import DATA, needs_recordings
from scenes import needs_compiler

import laserfeatures as lf
from laserfeatures.data import LineSegments
from laserfeatures.noise_model import NoiseModel, RangeNoise, noise_of
from laserfeatures.pipeline import Pipeline
from laserfeatures.simulation import Scanner, random_office, random_room

FLIRT = DATA / "sick" / "flirt_mit-cscail.log.gz"
SCANNER = Scanner(beams=361, range_max=20.0, range_sigma=0.005)


def office(seed):
    plan = random_office(seed // 10)
    x, y = plan.drive.waypoints[seed % 10 % len(plan.drive.waypoints)]
    return plan.world, lf.Pose2D(x, y, seed)


@functools.cache
def rooms(scans=50, scene=random_room, **scanner):
    made = replace(SCANNER, **scanner)
    return [made.scan(*scene(seed), np.random.default_rng(seed)) for seed in range(scans)]


def fed(scans, model=None):
    model = model or NoiseModel()
    return model, [model.feed(scan) for scan in scans]


def steps(noises, r):
    """Factors from one estimate to the next, of which there is one every 10 scans."""
    logs = np.log([each.at(r) for each in noises])
    return np.exp(np.abs(np.diff(logs)))


@needs_compiler
@pytest.mark.parametrize(("sigma", "relative"), [(0.005, 0.0), (0.010, 0.0), (0.004, 0.008)])
def test_it_settles_at_the_truth(sigma, relative):
    model, _ = fed(rooms(range_sigma=sigma, relative_sigma=relative))
    noise, truth = model.noise, RangeNoise(sigma=sigma, relative=relative)
    for r in (0.5, 2.0, 5.0):
        assert noise.at(r) == pytest.approx(truth.at(r), rel=0.05)
    assert noise.roughness < 0.001


@needs_compiler
def test_the_uncertainty_is_that_of_the_numbers():
    errors = []
    for k in range(12):
        seeds = range(500 + 20 * k, 520 + 20 * k)
        scans = [SCANNER.scan(*random_room(s), np.random.default_rng(s)) for s in seeds]
        model, _ = fed(scans)
        errors.append((model.noise.sigma - 0.005) / model.uncertainty.sigma)
    assert np.sqrt(np.mean(np.square(errors))) < 2.5
    assert 0 < model.uncertainty.sigma < 3e-4
    assert 0 <= model.uncertainty.relative < 2e-3
    assert 0 < model.uncertainty.roughness < 3e-3


@needs_compiler
def test_it_is_steady_where_single_scans_are_not():
    scans = rooms(120, scene=office, range_sigma=0.008, relative_sigma=0.002)
    _, noises = fed(scans)
    assert np.median(steps(noises[50::10], 3.0)) < 1.01
    assert steps(noises[50:], 3.0).max() < 1.03
    assert np.median(steps([noise_of(scan) for scan in scans], 3.0)) > 1.03


def test_clutter_of_half_of_the_beams_changes_little():
    rng = np.random.default_rng(5)
    scans = []
    for scan in rooms(range_sigma=0.010):
        ranges = scan.ranges.copy()
        for at in rng.choice(18, 9, replace=False) * 20:  # half of all runs of 20 beams
            ranges[at : at + 20] *= rng.uniform(0.2, 0.9, 20)
        scans.append(replace(scan, ranges=ranges))
    model, _ = fed(scans)
    assert model.noise.at(2.0) == pytest.approx(0.010, rel=0.1)


@needs_compiler
@pytest.mark.parametrize("sigma", [0.0, 0.001, 0.008])
def test_the_steps_of_quantised_ranges_count(sigma):
    fine = rooms(range_sigma=max(sigma, 1e-6))
    model, _ = fed([replace(scan, ranges=np.round(scan.ranges, 2)) for scan in fine])
    expected = math.hypot(sigma, 0.01 / math.sqrt(12))
    assert model.noise.at(2.0) == pytest.approx(expected, rel=0.1)


@needs_compiler
def test_a_roughness_of_walls_is_told():
    rng = np.random.default_rng(2)
    scans = []
    for scan in rooms(range_sigma=0.005):  # waves of 3 mm and about a metre, along the ranges
        wave = 0.003 * math.sqrt(2) * np.sin(scan.angles * 8 + rng.uniform(0, 6))
        scans.append(replace(scan, ranges=scan.ranges + wave))
    model, _ = fed(scans)
    assert 0.0005 < model.noise.roughness < 0.004
    assert model.noise.at(2.0) == pytest.approx(0.005, rel=0.05)


@pytest.mark.parametrize(
    "ranges", [[], [math.inf] * 40, [math.nan] * 40, [0.0] * 40, [1.0, math.inf] * 3]
)
def test_a_scan_without_returns_changes_nothing(ranges):
    model, _ = fed(rooms(5))
    before = pickle.dumps(model)
    blind = lf.LaserScan.uniform(ranges, 0.0, 0.01)
    assert model.feed(blind) == model.noise
    assert pickle.dumps(model) == before
    fresh = NoiseModel()
    assert fresh.feed(blind) == fresh.noise
    assert fresh.scans == 0
    assert fresh.uncertainty.sigma == math.inf


@needs_compiler
def test_the_same_scans_give_the_same_noise_and_a_copy_goes_on_alike():
    scans = rooms(60)
    model, first = fed(scans[:30])
    copied, pickled = copy.deepcopy(model), pickle.loads(pickle.dumps(model))  # noqa: S301
    _, rest = fed(scans[30:], model)
    assert fed(scans[30:], copied)[1] == rest
    assert fed(scans[30:], pickled)[1] == rest
    assert fed(scans)[1] == first + rest
    assert model.scans == 60


@needs_compiler
@pytest.mark.parametrize(("before", "after"), [(0.002, 0.010), (0.010, 0.002)])
def test_a_sensor_that_changes_is_followed(before, after):
    model = NoiseModel(memory=30)
    fed(rooms(60, range_sigma=before), model)
    fed(rooms(60, range_sigma=after), model)
    fed(rooms(60, range_sigma=after), model)
    assert model.noise.at(2.0) == pytest.approx(after, rel=0.15)


@needs_compiler
def test_it_takes_no_more_room_with_time():
    model, _ = fed(rooms(40))
    size = len(pickle.dumps(model))
    for _ in range(5):
        fed(rooms(60), model)
    assert len(pickle.dumps(model)) < size + 20_000  # 600 walls at most


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: NoiseModel(memory=0), "memory must be >= 1 scan, got 0"),
        (lambda: RangeNoise(sigma=0.0), r"sigma must be in \(0, 1\] m, got 0.0"),
        (lambda: RangeNoise(sigma=0.1, relative=-1), r"relative must be in \[0, 1\), got -1"),
        (lambda: RangeNoise(sigma=0.1, roughness=2), r"roughness must be in \[0, 1\] m, got 2"),
        (lambda: RangeNoise(sigma=0.1, correlation=2), r"correlation must be in \[0, 1\], got 2"),
    ],
)
def test_what_makes_no_sense_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("name", lf.list_extractors())
def test_every_extractor_of_ours_takes_the_noise(name):
    scan, extractor = rooms(1, range_sigma=0.010)[0], lf.get_extractor(name)
    tight, loose = (extractor(scan, noise=RangeNoise(sigma=s)) for s in (0.010, 0.040))
    assert len(tight.corners)
    same = tight.corners.covariance.shape == loose.corners.covariance.shape
    assert not (same and np.allclose(tight.corners.covariance, loose.corners.covariance))
    given = lf.get_extractor(name, range_sigma=0.010)
    told = given(scan, noise=RangeNoise(sigma=0.040)).corners.covariance
    assert np.array_equal(told, given(scan).corners.covariance)


def test_the_noise_is_the_same_as_the_parameters():
    scan = rooms(1)[0]
    noise = RangeNoise(sigma=0.006, relative=0.001, roughness=0.002)
    given = lf.get_extractor(
        "direct_hough", range_sigma=0.006, range_sigma_relative=0.001, roughness=0.002
    )
    told = lf.get_extractor("direct_hough")(scan, noise=noise)
    assert np.array_equal(told.corners.covariance, given(scan).corners.covariance)
    rough = lf.get_extractor("direct_hough", roughness=0.0)(scan, noise=noise)
    smooth = lf.get_extractor("direct_hough")(scan, noise=replace(noise, roughness=0.0))
    assert np.array_equal(rough.corners.covariance, smooth.corners.covariance)


@dataclass
class OnlyScan:
    def __call__(self, scan):
        return LineSegments.none(len(scan))


def test_a_detector_that_takes_only_a_scan_goes_on_working():
    scan = rooms(1)[0]
    for detector in (OnlyScan(), lambda scan: LineSegments.none(len(scan))):
        pipeline = Pipeline(name="other", detector=detector)
        assert not len(pipeline(scan, noise=RangeNoise(sigma=0.01)).lines)
        assert not len(pipeline(scan).lines)
    paper = lf.get_extractor("direct_hough", preset="paper")
    assert len(paper(scan, noise=RangeNoise(sigma=0.01)).lines) == len(paper(scan).lines)


@needs_compiler
@pytest.mark.skipif(not FLIRT.exists(), reason=f"{FLIRT} is missing")
def test_it_is_steady_on_a_real_log():
    with lf.open_source(FLIRT) as source:
        scans = list(source)
    model, noises = fed(scans)
    assert np.median(steps(noises[50::10], 3.0)) <= 1.02
    assert 0.004 < model.noise.sigma < 0.009
    assert 0.002 < model.noise.roughness < 0.008


@needs_recordings
@needs_compiler
@pytest.mark.parametrize(
    ("name", "low", "high"),
    [("sick/flirt_mit-cscail.log.gz", 0.0, 0.1), ("urg/brenner_robot4", 0.15, 0.35)],
)
def test_neighbours_err_alike_where_the_sensor_smooths(name, low, high):
    with lf.open_source(DATA / name) as log:
        model, _ = fed([scan for _, scan in zip(range(60), log, strict=False)])
    assert low <= model.noise.correlation <= high


@needs_recordings
@needs_compiler
def test_walls_of_an_arena_stay_whole():
    with lf.open_source(DATA / "urg" / "brenner_robot4") as log:
        scans = [scan for _, scan in zip(range(60), log, strict=False)]
    model, extractor = NoiseModel(), lf.get_extractor("direct_hough")
    lines = [len(extractor(scan, noise=model.feed(scan)).lines) for scan in scans]
    assert 3 <= np.median(lines) <= 7  # 20 before the correlation was told
    assert np.median([len(extractor(scan).lines) for scan in scans]) <= 9
