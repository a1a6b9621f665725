"""The component ``switch``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/switch.py``.
"""

from __future__ import annotations

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity

__all__ = ["build_switch"]


def build_switch(config: DiscoveryConfig) -> DescribedPart:
    """Describe a switch: a plug where its class is ``outlet``."""
    payloads = {True: config.text("payload_on", "ON"), False: config.text("payload_off", "OFF")}
    states = {
        config.text("state_on") or payloads[True]: True,
        config.text("state_off") or payloads[False]: False,
        "None": None,
    }
    entity = Entity(config, "plug" if config.text("device_class") == "outlet" else "switch")
    entity.add_flag("on_off", config.source("state_topic"), config.required_command(), payloads, states)
    return entity.build()
