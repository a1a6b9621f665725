"""The component ``device_tracker``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/device_tracker.py``.
"""

from __future__ import annotations

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings, clean_text
from homebot.errors import WireError

__all__ = ["build_device_tracker"]


def build_device_tracker(config: DiscoveryConfig) -> DescribedPart:
    """Describe what reports where somebody is. One that reports only coordinates has no place to report."""
    source = config.source("state_topic")
    if source is None and not config.has("json_attributes_topic"):
        raise WireError("device_tracker: it has neither state_topic nor json_attributes_topic")
    places: dict[str, str | None] = {
        config.text("payload_reset", "None"): None,
        config.text("payload_not_home", "not_home"): "not_home",
        config.text("payload_home", "home"): "home",
    }

    def read(text: str) -> Readings:
        if not text.strip():
            return NO_READINGS
        return {"place": places[text] if text in places else clean_text(text, _LONGEST)}

    entity = Entity(config, "x_tracker", config.clean_text("source_type"))
    entity.add_value("place", source, read)
    return entity.build()


_LONGEST = 120
