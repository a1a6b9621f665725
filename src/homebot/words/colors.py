"""Colours by their names, as hue and saturation or as a colour temperature. Pure.

Source: CSS Color Module Level 4, section 6.1 (named colours), as hue in degrees and saturation of HSV in per cent; the
white tones as lamps are sold.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

COLORS: Final[Mapping[str, tuple[float, float]]] = {
    "red": (0.0, 100.0),
    "coral": (16.0, 69.0),
    "orange": (39.0, 100.0),
    "gold": (51.0, 100.0),
    "yellow": (60.0, 100.0),
    "lime": (120.0, 100.0),
    "green": (120.0, 100.0),
    "turquoise": (174.0, 71.0),
    "cyan": (180.0, 100.0),
    "sky blue": (197.0, 43.0),
    "blue": (240.0, 100.0),
    "indigo": (275.0, 100.0),
    "violet": (300.0, 45.0),
    "purple": (300.0, 100.0),
    "magenta": (300.0, 100.0),
    "pink": (350.0, 25.0),
    "hot pink": (330.0, 59.0),
    "crimson": (348.0, 91.0),
    "white": (0.0, 0.0),
}

WHITES: Final[Mapping[str, float]] = MappingProxyType(
    {"warm white": 2700.0, "white": 4000.0, "neutral white": 4000.0, "cool white": 6500.0, "cold white": 6500.0}
)
"""Kelvin."""
