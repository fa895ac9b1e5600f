"""Client `rplidar` and its fork `rplidar-roboticia`: ``PORT BAUD SCANS [normal|express]``.

DTR: `lineless_serial` ignores that the port has none.
"""

import json
import sys
from itertools import islice

import lineless_serial  # noqa: F401 - before the client
from rplidar import RPLidar

port, baud, count, *mode = sys.argv[1:]
lidar = RPLidar(port, int(baud), timeout=3)
info, health = lidar.get_info(), lidar.get_health()
scans = [
    [[angle, distance] for _, angle, distance in scan]
    for scan in islice(lidar.iter_scans(*mode), int(count))
]
lidar.stop()
again = lidar.get_health()  # only a client in step with the device gets this answer
lidar.stop_motor()
lidar.disconnect()
sys.stdout.write(
    json.dumps({"info": info, "health": health, "again": again, "scans": scans}) + "\n"
)
