"""A port as a source: ``urg:///dev/ttyACM0?skip=1&scans=100``."""

from laserfeatures.data import LaserScan
from laserfeatures.drivers import Driver, Losses, make_driver
from laserfeatures.errors import DriverError
from laserfeatures.sources.live import Limits, LiveSource, limits_of, split_query

OWN = ("scans", "seconds")


class PortSource(LiveSource):
    """An open port.

    Parameters
    ----------
    driver : Driver
        What reads the port; it is opened, and closed with the source.
    limits : Limits
        When the source ends.
    name : str
        The port's address.
    range_max : float or None
        Overrides the sensor's limit [m].

    Raises
    ------
    DriverError
        If no such device answers there; the message says why.
    """

    def __init__(
        self, driver: Driver, limits: Limits, *, name: str, range_max: float | None = None
    ) -> None:
        self.driver = driver
        driver.open()
        super().__init__(name, driver.protocol, limits, range_max)

    @property
    def losses(self) -> Losses:
        """What has been lost so far."""
        return self.driver.losses

    @property
    def arrival(self) -> float:
        """When the first byte of the last scan came [s since the epoch]."""
        return self.driver.arrival

    def _wait(self) -> LaserScan:
        return next(self.driver)

    def close(self) -> None:
        """Stop the sweep and the laser, and close the port."""
        self.driver.close()


def driver_of(address: str) -> tuple[Driver, Limits]:
    """Return the driver of an address, not opened, and when its source is to end.

    Parameters
    ----------
    address : str
        As `make_driver` takes it, with ``scans=N`` and ``seconds=T`` besides.

    Raises
    ------
    DriverError
        If the address makes no sense.
    """
    try:
        rest, own = split_query(address, OWN)
        return make_driver(rest), limits_of(own)
    except ValueError as error:
        raise DriverError(f"{address}: {error}") from error
