"""Questions for devices: what they are made of, how they are spelt, and whether a device fits. Pure."""

from homebot.devices.query.facets import Facets, facets_of
from homebot.devices.query.parse import parse_query, quoted
from homebot.devices.query.terms import (
    And,
    CanDo,
    FactIs,
    FreshnessIs,
    GatewayIs,
    HasText,
    InArea,
    IsDisputed,
    Not,
    Or,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
    fits,
    type_is,
)

__all__ = [
    "And",
    "CanDo",
    "Facets",
    "FactIs",
    "FreshnessIs",
    "GatewayIs",
    "HasText",
    "InArea",
    "IsDisputed",
    "Not",
    "Or",
    "Query",
    "ReachableIs",
    "StateIs",
    "TypeIs",
    "facets_of",
    "fits",
    "parse_query",
    "quoted",
    "type_is",
]
