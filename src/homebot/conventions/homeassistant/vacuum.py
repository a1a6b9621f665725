"""The component ``vacuum``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/vacuum.py``.
"""

from __future__ import annotations

from functools import partial

from homebot.conventions.command_values import option_writer
from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import Readings, clean_text, fields_of, number_of
from homebot.devices.value import PlainValue

__all__ = ["build_vacuum"]


def build_vacuum(config: DiscoveryConfig) -> DescribedPart:
    """Describe a robot that cleans; it takes only the commands that its ``supported_features`` name."""
    features = frozenset(config.options("supported_features") if config.has("supported_features") else _FEATURES)
    command = config.command("command_topic", template_key="")
    set_speed = config.command("set_fan_speed_topic", template_key="")
    source = config.source("state_topic", template_key="")
    payloads = {
        state: config.text(key, default) for state, (feature, key, default) in _COMMANDS.items() if feature in features
    }
    speeds = config.options("fan_speed_list") if "fan_speed" in features else ()
    has_battery = "battery" in features
    entity = Entity(config, "robotic_vacuum_cleaner")
    is_readable = entity.read_text_from(source, partial(_read, has_speed=bool(speeds), has_battery=has_battery))
    writer = None
    if command and payloads:
        writer = option_writer("vacuum", payloads, lambda state: command.publish(payloads[state]))
    entity.add_capability("vacuum", readable=is_readable, writer=writer, options=tuple(payloads) if writer else ())
    if speeds:
        writer = option_writer("fan_mode", speeds, set_speed.publish) if set_speed else None
        entity.add_capability("fan_mode", readable=is_readable, writer=writer, options=speeds)
    if has_battery:
        entity.add_capability("battery", readable=is_readable, unit="%")
    if "locate" in features and command:
        entity.add_push("locate", command, config.text("payload_locate", "locate"))
    entity.add_commands(command, set_speed if speeds else None)
    return entity.build()


_FEATURES = ("start", "stop", "return_home", "battery", "clean_spot")
_STATES = frozenset({"cleaning", "docked", "paused", "idle", "returning", "error"})
_COMMANDS = {
    "cleaning": ("start", "payload_start", "start"),
    "paused": ("pause", "payload_pause", "pause"),
    "idle": ("stop", "payload_stop", "stop"),
    "returning": ("return_home", "payload_return_to_base", "return_to_base"),
    "spot": ("clean_spot", "payload_clean_spot", "clean_spot"),
}
"""Commands by state: the feature that it needs for that, and the payload."""

_LONGEST = 120


def _read(text: str, *, has_speed: bool, has_battery: bool) -> Readings:
    message = fields_of(text)
    found: dict[str, PlainValue] = {}
    state, speed, charge = (message.get(key) for key in ("state", "fan_speed", "battery_level"))
    if isinstance(state, str) and state in _STATES:
        found["vacuum"] = state
    elif "state" in message and state is None:
        found["vacuum"] = None
    if has_speed and isinstance(speed, str):
        found["fan_mode"] = clean_text(speed, _LONGEST)
    number = number_of(charge)
    if has_battery and number is not None:
        found["battery"] = max(0.0, min(100.0, number))
    return found
