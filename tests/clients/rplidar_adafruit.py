"""Client `adafruit-circuitpython-rplidar`: ``PORT BAUD SCANS``.

DTR: `lineless_serial` ignores that the port has none. Its express scan is not tried: it sends the
request without its payload.
"""

import json
import sys
from itertools import islice

import lineless_serial  # noqa: F401 - before the client
from adafruit_rplidar import RPLidar

port, baud, count = sys.argv[1:]
lidar = RPLidar(None, port, int(baud), timeout=3)
info, health = lidar.info, lidar.health
scans = [
    [[angle, distance] for _, angle, distance in scan]
    for scan in islice(lidar.iter_scans(), int(count))
]
lidar.stop()
lidar.stop_motor()
lidar.disconnect()
sys.stdout.write(json.dumps({"info": info, "health": health, "scans": scans}) + "\n")
