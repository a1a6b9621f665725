"""The component ``humidifier``: also dehumidifiers. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/humidifier.py``.
"""

from __future__ import annotations

from collections.abc import Callable

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import shown
from homebot.errors import WireError

__all__ = ["build_humidifier"]


def build_humidifier(config: DiscoveryConfig) -> DescribedPart:
    """Describe a humidifier; its tag says whether it takes the water out."""
    entity = Entity(config, "x_humidifier", config.clean_text("device_class") or "humidifier")
    payloads = {True: config.text("payload_on", "ON"), False: config.text("payload_off", "OFF")}
    entity.add_flag("on_off", config.source("state_topic", "state_value_template"), config.required_command(), payloads)
    least, most = config.number("min_humidity", 0.0), config.number("max_humidity", 100.0)
    if not 0 <= least < most <= 100:
        raise WireError(f"humidifier: max_humidity is {most:g}, not above min_humidity {least:g} and at most 100")
    unknown = config.text("payload_reset_humidity", "None")
    entity.add_number(
        "humidity_setpoint",
        config.source("target_humidity_state_topic", "target_humidity_state_template"),
        config.required_command("target_humidity_command_topic", "target_humidity_command_template"),
        bounds=(least, most),
        unit="%",
        unknown=unknown,
        from_device=_whole_within(least, most),
        to_device=int,
    )
    entity.add_number(
        "humidity",
        config.source("current_humidity_topic", "current_humidity_template"),
        None,
        unit="%",
        unknown=unknown,
        from_device=_whole_within(0, 100),
    )
    modes = config.options("modes")
    no_mode = config.text("payload_reset_mode", "None")
    if no_mode in modes:
        raise WireError(f"humidifier: modes has {shown(no_mode)}, which means that the mode is unknown")
    entity.add_choice(
        "humidifier_mode",
        config.source("mode_state_topic", "mode_state_template"),
        config.command("mode_command_topic", "mode_command_template"),
        modes,
        meanings={no_mode: None},
    )
    return entity.build()


def _whole_within(least: float, most: float) -> Callable[[float], float | None]:
    def convert(number: float) -> float | None:
        whole = float(round(number))
        return whole if least <= whole <= most else None

    return convert
