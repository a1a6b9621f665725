"""The component ``light``, in the schema that its config names. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/light/__init__.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import TypeAlias, cast

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.payload import shown
from homebot.errors import WireError
from homebot.lazy_names import lazy_names

__all__ = ["build_light"]


def build_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp."""
    schema = config.text("schema", "basic").lower()
    if schema not in _SCHEMAS:
        raise WireError(f"light: schema is {shown(config.text('schema'))}, not basic, json or template")
    return _builder_of(schema)(config)


_Builder: TypeAlias = Callable[[DiscoveryConfig], DescribedPart]

_SCHEMAS: Mapping[str, str] = {
    "basic": "build_basic_light",
    "json": "build_json_light",
    "template": "build_template_light",
}
_PACKAGE = __name__.rpartition(".")[0]
_load = lazy_names(__name__, {f"{_PACKAGE}.light_{schema}": builder for schema, builder in _SCHEMAS.items()})


@lru_cache(maxsize=len(_SCHEMAS))
def _builder_of(schema: str) -> _Builder:
    return cast("_Builder", _load(_SCHEMAS[schema]))
