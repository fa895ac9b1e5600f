"""Client `pyrplidarsdk`, which wraps the vendor's own C++ library: ``PORT BAUD SCANS``."""

import json
import math
import sys

from pyrplidarsdk import RplidarDriver

port, baud, count = sys.argv[1:]
lidar = RplidarDriver(port=port, baudrate=int(baud))
connected = lidar.connect()
info, health = lidar.get_device_info(), lidar.get_health()
started = lidar.start_scan()
scans = []
while len(scans) < int(count):
    angles, ranges, _ = lidar.get_scan_data()
    pairs = zip(angles, ranges, strict=True)
    scans.append([[math.degrees(angle), 1000 * range_] for angle, range_ in pairs if range_])
lidar.stop_scan()
lidar.disconnect()
answer = {
    "connected": connected,
    "started": started,
    "info": [info.model, info.firmware_version, info.hardware_version, info.serial_number],
    "health": [health.status, health.error_code],
    "scans": scans,
}
sys.stdout.write(json.dumps(answer) + "\n")
