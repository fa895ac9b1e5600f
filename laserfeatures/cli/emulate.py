"""``laserfeatures emulate``: a rangefinder that is not there."""

import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import click

from laserfeatures.cli import emulated, values
from laserfeatures.cli.emulated_device import MET, make_device
from laserfeatures.drivers.host_clock import now
from laserfeatures.emulators import FAULTS, Emulator
from laserfeatures.emulators.devices import DEVICES

FASTEST = 1000.0
LOOK = 0.1  # [s]; how soon a new port, an error or the end is noticed


@click.command()
@click.argument("device", type=click.Choice(list(DEVICES)))
@click.option("--world", type=click.Path(), metavar="PLAN", help="Floor plan; else a hallway.")
@click.option(
    "--at", type=emulated.Place(), metavar="X,Y,DEG", help="Where it stands, as 1m,2m,90deg."
)
@click.option(
    "--log", type=click.Path(), metavar="SOURCE", help="Scans to show instead, in a loop."
)
@click.option("--pty-link", type=click.Path(), metavar="PATH", help="Name of a link to its port.")
@click.option(
    "--tcp", type=click.IntRange(0, 65535), metavar="PORT", help="A TCP port instead; 0: any."
)
@click.option(
    "--fault",
    "faults",
    multiple=True,
    metavar="NAME[=RATE]",
    help=f"What hits a frame, 1 of 100 unless told: {', '.join(FAULTS)}; or what the host meets: "
    f"{', '.join(MET)}; or a fault of the device's own (docs/drivers.md). May be repeated.",
)
@click.option("--model", metavar="NAME", help="Which model of the device.")
@click.option("--state", metavar="NAME", help="In which state it is when the host comes.")
@click.option(
    "-p",
    "--param",
    "params",
    multiple=True,
    metavar="NAME=VALUE",
    help="Another parameter of the device, such as baud=38400.",
)
@click.option("--speed", type=float, default=1.0, help="Of its time.")
@click.option(
    "--seed", type=click.IntRange(min=0), default=0, metavar="N", help="Of noise and faults."
)
@click.option("--seconds", type=values.Quantity("s"), help="How long; else to Ctrl-C.")
def emulate(
    device: str,
    world: str | None,
    at: tuple[float, float, float] | None,
    log: str | None,
    pty_link: str | None,
    tcp: int | None,
    faults: tuple[str, ...],
    model: str | None,
    state: str | None,
    params: tuple[str, ...],
    speed: float,
    seed: int,
    seconds: float | None,
) -> None:
    """Play a rangefinder on a pseudo-terminal, byte for byte as the real one.

    DEVICE is urg, lms, rplidar or ld19. It scans a hallway, or the floor plan PLAN: there it drives
    along the plan's way-points, or stands at X,Y,DEG. Its port and the command that reads it are
    printed; then it runs until Ctrl-C.

    \b
    Examples:
      laserfeatures emulate urg --pty-link /tmp/urg --state streaming
      laserfeatures emulate lms --world office.toml --fault bit_flip=0.01 --fault unplug=0.001
      laserfeatures emulate rplidar --log example:clutter --speed 2
      laserfeatures emulate ld19 --world office.toml --at 2,1.5,90 -p turn_rate=6
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    if not 0 < speed <= FASTEST:
        raise click.UsageError(f"--speed must be in (0, {FASTEST:g}], got {speed:g}")
    if seconds is not None and not seconds > 0:
        raise click.UsageError(f"--seconds must be > 0 s, got {seconds:g}")
    if pty_link is not None and tcp is not None:
        raise click.UsageError("--pty-link and --tcp are two ways: give one")
    feed = emulated.make_feed(world, at, log, seed)
    made = make_device(
        device, feed, model=model, state=state, faults=faults, params=params, seed=seed
    )
    link = Path(pty_link) if pty_link else None
    emulator = Emulator(made, link=link, tcp=tcp, speed=speed)
    with suppress(KeyboardInterrupt), emulator:  # Ctrl-C is how it ends
        _play(emulator, device, seconds)
    _summary(Counter(fault or "whole" for _, fault in made.frames))


def _play(emulator: Emulator, device: str, seconds: float | None) -> None:
    port = told = ""
    end = now() + seconds if seconds else float("inf")
    while emulator.error is None and now() < end:
        with suppress(OSError):  # while it is unplugged
            port = emulator.port
        if port != told:
            told = port
            address = f"{device}:{port if '://' in port else f'//{Path(port).absolute()}'}"
            click.echo(f"{emulator.device.name} at {port}")
            click.echo(f"laserfeatures live {address}")
        time.sleep(LOOK)


def _summary(frames: Counter[str]) -> None:
    hit = ", ".join(f"{count} {name}" for name, count in sorted(frames.items()) if name != "whole")
    click.echo(
        f"laserfeatures: {frames.total()} frames of scans were sent; hit by faults: "
        f"{hit or 'none'}",
        err=True,
    )
