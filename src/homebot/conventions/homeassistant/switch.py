"""The component ``switch``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/switch.py``.
"""

from __future__ import annotations

from homebot.conventions.command_values import require_bool
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.value import PlainValue

__all__ = ["build_switch"]


def build_switch(config: DiscoveryConfig) -> DescribedPart:
    """Describe a switch: a plug where its class is ``outlet``."""
    command = config.required_command()
    payloads = {True: config.text("payload_on", "ON"), False: config.text("payload_off", "OFF")}
    states: dict[str, bool | None] = {
        config.text("state_on") or payloads[True]: True,
        config.text("state_off") or payloads[False]: False,
        "None": None,
    }

    def read(text: str) -> Readings:
        return {"on_off": states[text]} if text in states else NO_READINGS

    def write(value: PlainValue, _transition: float) -> tuple[Publication, ...]:
        return (command.publication(payloads[require_bool("on_off", value)]),)

    entity = Entity(config, "plug" if config.text("device_class") == "outlet" else "switch")
    entity.add_capability("on_off", readable=entity.read_text_from(config.source("state_topic"), read), writer=write)
    entity.add_commands(command)
    return entity.build()
