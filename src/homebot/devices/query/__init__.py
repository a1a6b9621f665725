"""Questions for devices: what they are made of, how they are spelt, and whether a device fits. Pure."""

from homebot.devices.query.facets import Facets, PartFacets, facets_of
from homebot.devices.query.parse import parse_query, quoted
from homebot.devices.query.terms import (
    And,
    AreaIs,
    CanDo,
    FactIs,
    FreshnessIs,
    GatewayIs,
    HasText,
    InArea,
    IsDisputed,
    NameIs,
    Not,
    Or,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
    fits,
    type_is,
)
from homebot.devices.query.wire import QueryTerm, query_terms, read_terms

__all__ = [
    "And",
    "AreaIs",
    "CanDo",
    "Facets",
    "FactIs",
    "FreshnessIs",
    "GatewayIs",
    "HasText",
    "InArea",
    "IsDisputed",
    "NameIs",
    "Not",
    "Or",
    "PartFacets",
    "Query",
    "QueryTerm",
    "ReachableIs",
    "StateIs",
    "TypeIs",
    "facets_of",
    "fits",
    "parse_query",
    "query_terms",
    "quoted",
    "read_terms",
    "type_is",
]
