"""Random scenes for the suites: rooms with partitions, offices; and rough walls."""

import math

import numpy as np

from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.simulation import Observation, World, random_room
from laserfeatures.simulation.raycast import cos_incidence

GRAZING = math.cos(math.radians(80.0))  # at a flatter angle roughness moves a return no more
CORRELATION = 0.15  # [m], how far along a wall a smooth roughness is alike
GRID = 0.03  # [m], between the points at which a smooth roughness is drawn
CLEARANCE = 0.4  # [m], least distance of the sensor from a surface
GAP = 0.02  # [m], least distance of a piece of furniture from others


def rooms(poles=0):
    """Return what makes today's random rooms, with that many poles, from a seed."""
    return lambda seed: random_room(seed, poles=poles)


def partitions(seed):
    """Return a large room with thin partitions and boxes, and a pose in it; all from `seed`.

    The room has 6 to 16 m by 5 to 12 m: a rectangle, one with a corner cut, an L or one with an
    oblique side. In it stand 2 to 5 partitions 8 to 15 cm thick, half of them attached to a wall,
    with a free end each, and up to three boxes of 0.4 to 1.5 m, turned anyhow.
    """
    rng = np.random.default_rng((seed, 7))
    while True:
        outline = _outline(rng)
        walls = World.outline(outline)
        boxes = []
        for _ in range(rng.integers(2, 6)):
            draw = _attached if rng.random() < 0.5 else _free
            boxes += _placed(rng, walls, boxes, draw, outline)
        for _ in range(rng.integers(0, 4)):
            boxes += _placed(rng, walls, boxes, _box, outline)
        world = World(walls=walls.walls, boxes=np.reshape(boxes, (-1, 5)))
        pose = _pose(rng, world, outline.min(axis=0), outline.max(axis=0), outline)
        if pose and len(boxes) >= 2:
            return world, pose


def offices(seed):
    """Return rooms in a row, in a grid or along a corridor, and a pose in one; all from `seed`.

    Walls are 8 to 15 cm thick, doors have jambs and one in four is closed; radiators, cupboards
    and tables on four legs stand about.
    """
    rng = np.random.default_rng((seed, 8))
    x, y, corridor = _grid(rng)
    thickness = rng.uniform(0.08, 0.15)
    boxes, doors = _grid_walls(rng, x, y, corridor, thickness)
    way = np.reshape(doors, (-1, 2))
    poles = []
    cells = [(i, j) for i in range(len(x) - 1) for j in range(len(y) - 1)]
    for i, j in cells:
        low = np.array((x[i], y[j])) + thickness / 2
        high = np.array((x[i + 1], y[j + 1])) - thickness / 2
        if j == corridor:
            continue
        _furnish(rng, boxes, poles, way, low, high)
    world = World(boxes=np.array(boxes), poles=np.reshape(poles, (-1, 3)))
    while True:
        i, j = cells[rng.integers(len(cells))]
        pose = _pose(rng, world, np.array((x[i], y[j])), np.array((x[i + 1], y[j + 1])))
        if pose:
            return world, pose


def roughened(observation, sigma, rng, *, length=0.0):
    """Return an observation whose returns are moved along the normal of the wall that they hit.

    Parameters
    ----------
    observation : Observation
        A scan and its truth.
    sigma : float
        Standard deviation of the roughness [m].
    rng : numpy.random.Generator
        Source of randomness.
    length : float
        0: every beam is moved by itself. Otherwise how far along a wall the displacement is
        correlated [m]: its correlation at distance s is exp(-s^2 / (2 length^2)).
    """
    scan, world, pose = observation.scan, observation.world, observation.pose
    position, angles = np.array((pose.x, pose.y)), scan.angles + pose.theta
    surface = observation.surface
    flat = (surface >= 0) & (surface < len(world.sides))
    white = rng.normal(0.0, sigma, len(scan))
    shift = _smooth(observation, flat, sigma, length, rng) if length else white
    cosine = np.maximum(cos_incidence(world, position, angles, surface), GRAZING)
    ranges = scan.ranges + np.where(flat, shift / cosine, 0.0)
    moved = LaserScan(
        angles=scan.angles, ranges=ranges, range_min=scan.range_min, range_max=scan.range_max,
        stamp=scan.stamp, pose=scan.pose,
    )  # fmt: skip
    seen = np.where(moved.valid, surface, -1)
    return Observation(scan=moved, world=world, pose=pose, surface=seen)


def _smooth(observation, flat, sigma, length, rng):
    """Return the displacement of each beam [m] on walls that are rough smoothly, (N,)."""
    scan, world, pose = observation.scan, observation.world, observation.pose
    shift = np.zeros(len(scan))
    width = length / math.sqrt(2)  # white noise through a Gaussian this wide
    reach = math.ceil(4 * width / GRID)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) * GRID / width) ** 2)
    kernel *= sigma / math.sqrt((kernel**2).sum())
    for number in np.unique(observation.surface[flat]):
        start, end = world.sides[number]
        whole = math.dist(start, end)
        nodes = math.ceil(whole / GRID) + 2
        profile = np.convolve(rng.normal(size=nodes + 2 * reach), kernel, mode="valid")
        mine = flat & (observation.surface == number)
        hit = pose.transform(scan.ranges[mine, None] * scan.directions[mine])
        along = (hit - start) @ (end - start) / whole
        shift[mine] = np.interp(along, GRID * np.arange(nodes), profile)
    return shift


# Rooms with partitions


def _outline(rng):
    """Return the corners of a room, counter-clockwise, (n, 2)."""
    width, depth = rng.uniform((6, 5), (16, 12))
    corners = np.array([(0, 0), (width, 0), (width, depth), (0, depth)])
    kind = rng.integers(4)
    if kind == 0:
        return corners
    k = int(rng.integers(4))
    corners = np.roll(corners, -k, axis=0)  # what is changed is the first corner
    first, after, before = corners[0], corners[1], corners[3]
    near, far = rng.uniform(0.1, 0.5, 2)
    on_before, on_after = first + near * (before - first), first + far * (after - first)
    if kind == 1:
        return np.array([on_before, on_after, *corners[1:]])
    if kind == 2:
        notch = on_before + on_after - first
        return np.array([on_before, notch, on_after, *corners[1:]])
    return np.array([on_before, *corners[1:]])


def _attached(rng, outline):
    """Return a partition from a wall inwards, which it reaches through."""
    k = int(rng.integers(len(outline)))
    start, end = outline[k], outline[(k + 1) % len(outline)]
    along = (end - start) / math.dist(start, end)
    inward = np.array([-along[1], along[0]])
    foot = start + rng.uniform(0.15, 0.85) * (end - start)
    length, behind = rng.uniform(0.8, 4.0), 0.05
    centre = foot + inward * (length / 2 - behind)
    return [*centre, length, rng.uniform(0.08, 0.15), math.atan2(inward[1], inward[0])], behind


def _free(rng, outline):
    """Return a free-standing partition, most of them along the room's axes."""
    turn = rng.choice([0.0, math.pi / 2]) if rng.random() < 0.7 else rng.uniform(0, math.pi)
    centre = rng.uniform(outline.min(axis=0), outline.max(axis=0))
    return [*centre, rng.uniform(0.8, 4.0), rng.uniform(0.08, 0.15), turn], None


def _box(rng, outline):
    """Return a box of 0.4 to 1.5 m, turned anyhow."""
    centre = rng.uniform(outline.min(axis=0), outline.max(axis=0))
    return [*centre, *rng.uniform(0.4, 1.5, 2), rng.uniform(0, math.pi)], None


def _placed(rng, walls, boxes, draw, outline):
    """Return one drawn box that touches nothing but the wall that it is attached to, or none."""
    for _ in range(40):
        box, behind = draw(rng, outline)
        points = _perimeter(box)
        if behind is not None:
            c, s = math.cos(box[4]), math.sin(box[4])
            ahead = (points - box[:2]) @ (c, s) + box[2] / 2
            points = points[ahead > behind + 0.3]
        others = World(walls=walls.walls, boxes=np.reshape(boxes, (-1, 5)))
        if others.distances(points).min() > 0.25 and _inside(outline, points).all():
            return [box]
    return []


def _perimeter(box):
    """Return points on a box's sides, at most 10 cm apart, (n, 2)."""
    sides = World(boxes=[box]).sides
    parts = []
    for start, end in sides:
        share = np.linspace(0, 1, 2 + int(math.dist(start, end) / 0.1))[:, None]
        parts.append(start + share * (end - start))
    return np.concatenate(parts)


def _inside(polygon, points):
    """Tell which points lie in a polygon (n, 2), by the crossings of a ray to the right."""
    start, end = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    across = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    at = start[:, 0] + (y - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    return (across & (x < at)).sum(axis=1) % 2 == 1


def _pose(rng, world, low, high, outline=None):
    """Return a pose between two corners that is clear of everything, or None."""
    for _ in range(100):
        x, y = rng.uniform(low, high)
        clear = world.distances((x, y)).min() > CLEARANCE
        if clear and (outline is None or _inside(outline, np.array([(x, y)]))[0]):
            return Pose2D(float(x), float(y), rng.uniform(-math.pi, math.pi))
    return None


# Offices


def _grid(rng):
    """Return where the walls of a grid of rooms are in x and y [m], and which row is a corridor."""
    kind = rng.choice(["row", "grid", "corridor"])
    columns = rng.integers(2, 5) if kind != "grid" else rng.integers(2, 4)
    widths = rng.uniform(2.6, 5.0, columns)
    depths = rng.uniform(3.0, 6.0, {"row": 1, "grid": 2, "corridor": 3}[str(kind)])
    if kind == "corridor":
        depths[1] = rng.uniform(1.5, 2.4)
    corridor = 1 if kind == "corridor" else -1
    return np.append(0, np.cumsum(widths)), np.append(0, np.cumsum(depths)), corridor


def _grid_walls(rng, x, y, corridor, thickness):
    """Return the boxes of all walls, and points in the doors that are to be kept free."""
    boxes, doors = [], []
    for k, at in enumerate(x):
        for j in range(len(y) - 1):
            outer = k in {0, len(x) - 1}
            if outer or j != corridor:
                _wall(rng, boxes, doors, (at, y[j]), y[j + 1] - y[j], 1, thickness, not outer)
    for k, at in enumerate(y):
        for i in range(len(x) - 1):
            outer = k in {0, len(y) - 1}
            _wall(rng, boxes, doors, (x[i], at), x[i + 1] - x[i], 0, thickness, not outer)
    return boxes, doors


def _wall(rng, boxes, doors, start, length, axis, thickness, inner):
    """Add a wall from `start` along an axis, perhaps with a door; it reaches into its neighbours.

    Walls end in the middle of those that they meet, so that no end of one is flush with a face.
    """
    over = thickness / 4
    wide = rng.uniform(0.8, 1.0)
    at = 0.3 + rng.random() * max(length - 0.6 - wide, 0.0)
    kind = rng.random()
    start = np.array(start)
    along = np.eye(2)[axis]

    def add(low, high, thick):
        centre = start + along * (low + high) / 2
        boxes.append([*centre, high - low, thick, axis * math.pi / 2])

    if not inner or kind < 0.2:
        add(-over, length + over, thickness)
        return
    add(-over, at, thickness)
    add(at + wide, length + over, thickness)
    if kind < 0.4:  # closed: a leaf that stands back from both faces
        add(at - 0.02, at + wide + 0.02, 0.04)
    middle = start + along * (at + wide / 2)
    doors.extend(middle + step * np.eye(2)[1 - axis] for step in (-0.5, 0.0, 0.5))


def _furnish(rng, boxes, poles, way, low, high):
    """Put radiators, cupboards and a table into a room; what finds no place is left out."""
    for _ in range(rng.integers(0, 3)):
        size = rng.uniform(0.6, 1.6), rng.uniform(0.05, 0.12)
        _against(rng, boxes, way, low, high, size, rng.uniform(0.03, 0.05))
    for _ in range(rng.integers(0, 3)):
        size = rng.uniform(0.6, 1.2), rng.uniform(0.35, 0.6)
        _against(rng, boxes, way, low, high, size, rng.uniform(0.025, 0.04))
    if rng.random() < 0.6:
        half = rng.uniform((0.55, 0.3), (0.9, 0.45))
        c, s = math.cos(turn := rng.uniform(0, math.pi)), math.sin(turn)
        legs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half @ np.array([[c, s], [-s, c]])
        legs += rng.uniform(low + 0.9, high - 0.9)
        if World(boxes=boxes).distances(legs).min() > 0.1:
            radius = rng.uniform(0.02, 0.04)
            poles += [[*leg, radius] for leg in legs]


def _against(rng, boxes, way, low, high, size, gap):
    """Add a box of that length and depth before a wall of a room, if there is a place."""
    side, axis = int(rng.integers(2)), int(rng.integers(2))
    for _ in range(10):
        centre = np.empty(2)
        room = high[axis] - low[axis] - size[0] - 0.1
        if room <= 0:
            return
        centre[axis] = low[axis] + 0.05 + size[0] / 2 + room * rng.random()
        inset = gap + size[1] / 2
        centre[1 - axis] = high[1 - axis] - inset if side else low[1 - axis] + inset
        box = [*centre, *size, axis * math.pi / 2]
        alone = World(boxes=[box])
        clear = not len(way) or alone.distances(way).min() > 0.25
        if clear and World(boxes=boxes).distances(_perimeter(box)).min() > GAP:
            boxes.append(box)
            return
