"""Client `rplidarc1`: ``PORT BAUD SCANS``. It tells measurements, not turns.

DTR: `lineless_serial` ignores that the port has none.
"""

import asyncio
import json
import sys

import lineless_serial  # noqa: F401 - before the client
from rplidarc1 import RPLidar

TURN = 300  # measurements


async def measure(lidar, count):
    """Return measurements, and stop."""
    task = asyncio.create_task(lidar.simple_scan())
    measured = []
    while len(measured) < count:
        measured.append(await lidar.output_queue.get())
        lidar.output_queue.task_done()
    lidar.stop_event.set()
    task.cancel()
    return measured


port, baud, turns = sys.argv[1:]
lidar = RPLidar(port, int(baud), timeout=3)
measured = asyncio.run(measure(lidar, int(turns) * TURN))
lidar.reset()
lidar.shutdown()
points = [[one["a_deg"], one["d_mm"]] for one in measured if one["d_mm"]]
scans = [points[i : i + TURN] for i in range(0, len(points), TURN)]
sys.stdout.write(json.dumps({"scans": scans}) + "\n")
