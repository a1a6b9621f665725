"""Numbers by which probes report an error, for devices with a known probe. Pure."""

from typing import NamedTuple

from homebot.conventions.unreadable import Readings, unreadable

_NEAR = 0.05
"""Greatest difference to an error after a conversion from °F."""


class ProbeError(NamedTuple):
    """A number that is no reading; that of any other device, such as a boiler, may be one."""

    capability: str
    number: float
    meaning: str


DS18X20_RESET = ProbeError("temperature", 85.0, "85 °C of a DS18x20 follows a loss of its power")
DS18X20_GONE = ProbeError("temperature", -127.0, "-127 °C of a DS18x20 means that it does not answer")


def read_probe(readings: Readings, *errors: ProbeError) -> Readings:
    """Return *readings* of a probe without its *errors*, which are recorded as unreadable."""
    for error in errors:
        number = readings.get(error.capability)
        if isinstance(number, float) and abs(number - error.number) < _NEAR:
            return unreadable(number, f"a reading; {error.meaning}")
    return readings
