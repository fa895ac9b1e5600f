"""The peers of the extractors: public routines that find lines, called as a user would call them.

Each function takes a case of `contest` and returns the call that is timed, without arguments, and
what turns its result into theta [rad] and d [m], to be checked. Points are Cartesian and the image
is drawn beforehand, in the peers' favour.
"""

import contest
import cv2
import numpy as np
from laserfeatures_plugins.raster.drawing import Blur, draw
from laserfeatures_plugins.raster.outline import outline
from skimage.measure import LineModelND, ransac
from skimage.transform import hough_line, hough_line_peaks

import laserfeatures as lf
from laserfeatures.evaluation.true_lines import lines_through

SHORTEST = 0.5  # [m], of a wall that a user of an image would ask for
TRIALS = 100  # of skimage's RANSAC, its default
INLIER = 3 * contest.RANGE_SIGMA  # [m]


def point_set(case):
    """`cv2.HoughLinesPointSet` on the points."""
    return contest.peer_call(case.scan, contest.sensor_range(case.scan)), contest.peer_lines


def bare_hough(case):
    """`cv2.HoughLines` exactly as `raster_hough` calls it, on its very image."""
    return _hough(case, lf.get_extractor("raster_hough").detector.min_votes)


def hough(case):
    """`cv2.HoughLines` on the same image, for walls of half a metre."""
    return _hough(case, round(SHORTEST / picture_of(case.scan).resolution))


def segments(case):
    """`cv2.HoughLinesP` on the same image: segments of half a metre."""
    picture = picture_of(case.scan)
    shortest, gap = round(SHORTEST / picture.resolution), 0.25 / picture.resolution

    def call():
        return cv2.HoughLinesP(picture.image, 1, contest.THETA_STEP, shortest, None, shortest, gap)

    def read(found):
        ends = np.asarray(found, dtype=float).reshape(-1, 2, 2)
        ends = ends * picture.resolution + (picture.x, picture.y)
        return _through(ends[:, 0], ends[:, 1])

    return call, read


def scikit_hough(case):
    """`skimage.transform.hough_line` and its peaks on the same image."""
    picture = picture_of(case.scan)
    theta = np.arange(-90, 90) * contest.THETA_STEP
    votes = round(SHORTEST / picture.resolution)

    def call():
        return hough_line_peaks(*hough_line(picture.image, theta), threshold=votes)

    def read(found):
        _, angles, distances = found
        return _in_metres(picture, angles, distances)

    return call, read


def scikit_ransac(case):
    """`skimage.measure.ransac` on the points, one wall after the other, as many as there are."""

    def call():
        points, models = case.scan.points, []
        for seed in range(case.truth.theta.size):
            model, inliers = ransac(
                points, LineModelND, min_samples=2, residual_threshold=INLIER,
                max_trials=TRIALS, stop_probability=0.99, rng=seed,
            )  # fmt: skip
            models.append(model)
            points = points[~inliers]
        return models

    def read(models):
        origins = np.array([model.origin for model in models])
        return _through(origins, origins + [model.direction for model in models])

    return call, read


FAST = {
    "cv2.HoughLinesPointSet": point_set,
    "cv2.HoughLines, the image and arguments of raster_hough": bare_hough,
    "cv2.HoughLines, the same image, 0.5 m": hough,
    "cv2.HoughLinesP, the same image, 0.5 m": segments,
}
SLOW = {
    "skimage hough_line and peaks, the same image, 0.5 m": scikit_hough,
    "skimage ransac, as many lines as walls": scikit_ransac,
}


def picture_of(scan):
    """Return the image that `raster_hough` makes of a scan, to keep."""
    own = lf.get_extractor("raster_hough").detector
    drawn = outline(
        own.prepared(scan),
        resolution=own.resolution,
        max_pole_radius=own.max_pole_radius,
        max_range=own.max_range,
        min_incidence=own.min_incidence,
        max_missed=own.max_missed,
    )
    picture = draw(drawn, own.resolution, Blur(own.blur, own.blur_growth))
    return picture._replace(image=picture.image.copy())


def _hough(case, votes):
    picture = picture_of(case.scan)

    def call():
        return cv2.HoughLines(picture.image, 1.0, contest.THETA_STEP, votes - 1)

    def read(found):
        rho, theta = np.asarray(found).reshape(-1, 2)[: contest.LINES_MAX].T
        return _in_metres(picture, theta, rho)

    return call, read


def _in_metres(picture, theta, rho):
    """Return theta and d [m] of the lines (theta, rho [pixels]) of an image."""
    d = rho * picture.resolution + picture.x * np.cos(theta) + picture.y * np.sin(theta)
    return theta, d


def _through(start, end):
    """Return theta and d of the lines through points (L, 2)."""
    return np.stack(lines_through(np.stack([start, end], axis=1)))
