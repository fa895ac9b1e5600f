"""Client `pyrplidar`: ``PORT BAUD SCANS MODE``; mode -1 is the standard scan, else an express one.

DTR: `lineless_serial` ignores that the port has none.
"""

import json
import sys
import time

import lineless_serial  # noqa: F401 - before the client
from pyrplidar import PyRPlidar

port, baud, count, mode = sys.argv[1:]
lidar = PyRPlidar()
lidar.connect(port, int(baud), 3)
info, health, rate = lidar.get_info(), lidar.get_health(), lidar.get_samplerate()
names = [scan_mode.name for scan_mode in lidar.get_scan_modes()]
typical = lidar.get_scan_mode_typical()
lidar.set_motor_pwm(660)
generator = lidar.start_scan() if mode == "-1" else lidar.start_scan_express(int(mode))
scans = [[]]
for measured in generator():
    if measured.start_flag:
        scans.append([])
        if len(scans) == int(count) + 2:
            break
    if measured.distance:
        scans[-1].append([measured.angle, measured.distance])
lidar.stop()
time.sleep(0.05)
lidar.set_motor_pwm(0)
lidar.disconnect()
answer = {
    "info": vars(info),
    "health": vars(health),
    "rate": vars(rate),
    "names": names,
    "typical": typical,
    "scans": scans[1:-1],
}
sys.stdout.write(json.dumps(answer) + "\n")
