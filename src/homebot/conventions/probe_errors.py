"""Numbers by which probes report an error, for devices whose probe is known. Pure."""

from collections.abc import Mapping
from typing import NamedTuple

from homebot.conventions.unreadable import Readings, unreadable

__all__ = ["read_probe"]

_NEAR = 0.05
"""Greatest difference to an error after a conversion from °F."""


class _Error(NamedTuple):
    capability: str
    number: float
    meaning: str


_RESET = _Error("temperature", 85.0, "85 °C of a DS18x20 follows a loss of its power")
_GONE = _Error("temperature", -127.0, "-127 °C of a DS18x20 means that it does not answer")

_ERRORS: Mapping[str, tuple[_Error, ...]] = {
    "tasmota DS18x20": (_RESET, _GONE),  # arendst/Tasmota#2168, #5983; DallasTemperature.h, DEVICE_DISCONNECTED_C
    "shelly add-on": (_RESET,),  # home-assistant/core#177168; its other probe, a DHT22, ends at 80 °C
}
"""By device and probe. The same number of any other device, such as a boiler, is a reading."""


def read_probe(probe: str, readings: Readings) -> Readings:
    """Return *readings* of *probe* without its error values, which are recorded as unreadable."""
    for error in _ERRORS[probe]:
        number = readings.get(error.capability)
        if isinstance(number, float) and abs(number - error.number) < _NEAR:
            return unreadable(number, f"a reading; {error.meaning}")
    return readings
