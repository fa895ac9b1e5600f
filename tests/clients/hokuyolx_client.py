"""hokuyolx reads from a URG; prints what it got."""

import json
import sys
import time

from hokuyolx import HokuyoLX
from hokuyolx.exceptions import HokuyoStatusException

laser = HokuyoLX(
    addr=(sys.argv[1], int(sys.argv[2])), activate=False, tsync=False, convert_time=False
)
seen = {"model": laser.model, "steps": [laser.amin, laser.amax, laser.aforw, laser.ares]}
seen["frequency"] = laser.scan_freq
seen["version"], seen["state"] = laser.version(), laser.sensor_state()
try:
    laser.laser_state()  # %ST, which models of that time do not know
except HokuyoStatusException as error:
    seen["unknown"] = str(error)
seen["enter"] = laser.tsync_enter()
begin = time.time()
clocks = [laser.tsync_get() for _ in range(10)]
seen["clock"] = [clocks[-1] - clocks[0], (time.time() - begin) * 1000]
seen["exit"] = laser.tsync_exit()
seen["activate"] = laser.activate()
seen["again"] = laser.activate()
single = [laser.get_dist() for _ in range(2)]
seen["single"] = [[int(time_), scan.tolist()] for time_, scan in single]
seen["grouped"] = laser.get_dist(44, 725, 3)[1].tolist()
stream = laser.iter_dist(scans=5, skips=1)
seen["stream"] = [[int(time_), scan.tolist(), left] for scan, time_, left in stream]
laser.standby()
laser.reset()
laser.close()
print(json.dumps(seen))  # noqa: T201 - read by the test
