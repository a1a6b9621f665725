"""Units as Thing Descriptions spell them. Pure."""

from __future__ import annotations

from homebot.wot.thing import DataSchema
from homebot.wot.vocabulary import UNITS

__all__ = ["unit_of"]


def unit_of(schema: DataSchema) -> str:
    """Return the unit of a schema, as the vocabulary spells it: ``celsius`` and ``unit:DegreeCelsius`` are ``°C``."""
    bare = schema.unit.rpartition("/")[2].rpartition(":")[2] if ":" in schema.unit else schema.unit
    return UNITS.get(bare.casefold().strip(), schema.unit)
