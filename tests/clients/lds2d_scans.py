"""Client `lds2d`: ``PORT MODEL SCANS``; it reads RPLIDARs and LDROBOT's devices.

DTR: it sets none. With an RPLIDAR it neither resets nor asks for health.
"""

import json
import sys
from itertools import islice

from lds2d import Lidar

port, model, count = sys.argv[1:]
with Lidar.open(model, port) as lidar:
    scans = [
        [[point.angle_deg, point.dist_mm] for point in scan if point.valid]
        for scan in islice(lidar.scans(), int(count) + 1)
    ]
sys.stdout.write(json.dumps({"scans": scans[1:]}) + "\n")  # the first is a part of a turn
