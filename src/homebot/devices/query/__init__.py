"""Queries for devices: their terms, their text form, and matching against devices. Pure."""

from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.devices.query.exact import parse_exact_query
    from homebot.devices.query.facets import Facets, facets_of
    from homebot.devices.query.matching import PartFacets, fits
    from homebot.devices.query.parse import parse_query
    from homebot.devices.query.term_messages import QueryTerm, query_terms, read_terms
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
        IsNear,
        IsUnapproved,
        NameIs,
        Not,
        Or,
        Query,
        ReachableIs,
        StateIs,
        TypeIs,
        split_near,
        type_is,
    )
    from homebot.devices.query.tokens import quoted
    from homebot.devices.query.vocabulary import FIELDS

__all__ = [
    "FIELDS",
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
    "IsNear",
    "IsUnapproved",
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
    "parse_exact_query",
    "parse_query",
    "query_terms",
    "quoted",
    "read_terms",
    "split_near",
    "type_is",
]

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.devices.query.exact": "parse_exact_query",
            "homebot.devices.query.facets": "Facets facets_of",
            "homebot.devices.query.matching": "PartFacets fits",
            "homebot.devices.query.parse": "parse_query",
            "homebot.devices.query.terms": """
                And AreaIs CanDo FactIs FreshnessIs GatewayIs HasText InArea IsDisputed IsNear IsUnapproved NameIs Not
                Or Query ReachableIs StateIs TypeIs split_near type_is
                """,
            "homebot.devices.query.term_messages": "QueryTerm query_terms read_terms",
            "homebot.devices.query.tokens": "quoted",
            "homebot.devices.query.vocabulary": "FIELDS",
        },
    )
