"""Sources of the values of climate devices. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/climate.py``.
"""

from __future__ import annotations

from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.value_source import ValueSource

__all__ = ["source_at", "source_of"]


def source_of(config: DiscoveryConfig, name: str) -> ValueSource | None:
    """Return where a climate device says *name*; one template may stand for all that have none of their own."""
    return source_at(config, f"{name}_topic", f"{name}_template")


def source_at(config: DiscoveryConfig, topic_key: str, template_key: str) -> ValueSource | None:
    """As :func:`source_of`, for fields that are called otherwise."""
    return config.source(topic_key, template_key if config.has(template_key) else "value_template")
