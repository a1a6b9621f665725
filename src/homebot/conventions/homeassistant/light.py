"""The component ``light``, in the schema that its config names. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/light/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.light_basic import build_basic_light
from homebot.conventions.homeassistant.light_json import build_json_light
from homebot.conventions.homeassistant.light_template import build_template_light
from homebot.conventions.payload import shown
from homebot.errors import WireError

__all__ = ["build_light"]


def build_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp."""
    schema = config.text("schema", "basic")
    builder = _SCHEMAS.get(schema.lower())
    if builder is None:
        raise WireError(f"light: schema is {shown(schema)}, not basic, json or template")
    return builder(config)


_SCHEMAS: Mapping[str, Callable[[DiscoveryConfig], DescribedPart]] = {
    "basic": build_basic_light,
    "json": build_json_light,
    "template": build_template_light,
}
