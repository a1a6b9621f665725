"""The component ``number``: a setting that is a number. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/number.py``.
"""

from __future__ import annotations

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.errors import WireError

__all__ = ["build_number"]


def build_number(config: DiscoveryConfig) -> DescribedPart:
    """Describe a number in its own unit; what lies outside of its bounds is neither read nor sent."""
    least, most = config.number("min", 0.0), config.number("max", 100.0)
    if least > most:
        raise WireError(f"number: max is {most:g}, below min {least:g}")

    def from_device(number: float) -> float | None:
        return number if least <= number <= most else None

    entity = Entity(config, "x_setting")
    entity.add_number(
        "number",
        config.source("state_topic"),
        config.required_command(),
        bounds=(least, most),
        unit=config.clean_text("unit_of_measurement", 40),
        unknown=config.text("payload_reset", "None"),
        from_device=from_device,
        to_device=_shortest,
    )
    return entity.build()


def _shortest(number: float) -> float:
    """Return *value* as it is sent: a whole number without point."""
    return int(number) if number.is_integer() else number
