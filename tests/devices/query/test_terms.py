"""Queries as messages: what is sent is what arrives, and what is no query is an error that names the term."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.devices.query.term_messages import MAX_DEPTH, MAX_TERMS, QueryTerm, query_terms, read_terms
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
    IsUnapproved,
    NameIs,
    Not,
    Or,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
)
from homebot.devices.services import FindDevicesRequest
from homebot.errors import UsageError
from homebot.words.queries import parse_query


def exact(number: float) -> float:
    """Return *number* with the 15 significant digits that values carry."""
    return float(f"{number:.15g}") if abs(number) < 1e15 else number


_texts = st.text(max_size=8)
_types = st.frozensets(st.sampled_from(["light", "plug", "switch"]))
_values = (
    st.booleans()
    | st.floats(allow_nan=False, allow_infinity=False).map(exact)
    | _texts
    | st.tuples(st.floats(0, 1).map(exact), st.floats(0, 1).map(exact))
)
_leaves: st.SearchStrategy[Query] = st.one_of(
    st.builds(TypeIs, _texts, _types, st.sampled_from(["", "window"]), st.booleans()),
    st.builds(CanDo, _texts, st.booleans()),
    st.builds(InArea, _texts),
    st.builds(AreaIs, _texts),
    st.builds(NameIs, _texts),
    st.builds(StateIs, _texts, st.sampled_from(["=", "!=", "<", "<=", ">", ">="]), _values, _types),
    st.builds(HasText, _texts),
    st.builds(FreshnessIs, _texts),
    st.builds(ReachableIs, _texts),
    st.builds(GatewayIs, _texts),
    st.builds(FactIs, _texts, _texts),
    st.just(IsDisputed()),
    st.just(IsUnapproved()),
)


def _groups(inner: st.SearchStrategy[Query]) -> st.SearchStrategy[Query]:
    several = st.lists(inner, max_size=4).map(tuple)
    return st.builds(And, several) | st.builds(Or, several) | st.builds(Not, inner)


@given(st.recursive(_leaves, _groups, max_leaves=20))
def test_a_query_is_the_same_after_it_has_travelled(query: Query) -> None:
    sent = FindDevicesRequest(query=query_terms(query))
    assert read_terms(FindDevicesRequest.model_validate_json(sent.model_dump_json()).query) == query


@pytest.mark.parametrize(
    "text", ["light and dimmable in kitchen", "on lights not stale", "temperature < 3 or battery<10"]
)
def test_a_text_means_the_same_as_its_terms(text: str) -> None:
    query = parse_query(text)
    assert read_terms(query_terms(query)) == query


@pytest.mark.parametrize(
    "text",
    [
        "(x or (y " * 9 + "opening or not lamps" + "))" * 9,
        "not " * 20 + "open lights",
        "open " * 98 + '"' + " ".join(map(chr, range(0x4E00, 0x4E00 + 250))) + '"',
    ],
    ids=["the deepest brackets", "the most negations", "the most words"],
)
def test_a_text_of_the_greatest_size_can_travel(text: str) -> None:
    query = parse_query(text)
    assert read_terms(query_terms(query)) == query


def test_a_term_stands_before_its_operands() -> None:
    query = And((TypeIs("lamps", frozenset({"light"})), Not(FreshnessIs("stale"))))
    assert [(term.kind, term.operands) for term in query_terms(query)] == [
        ("and", 2),
        ("type", 0),
        ("not", 1),
        ("freshness", 0),
    ]


def test_no_terms_are_a_query_that_everything_fits() -> None:
    assert read_terms(()) == And(())


@pytest.mark.parametrize(
    ("terms", "problem"),
    [
        ([QueryTerm(kind="and", operands=2), QueryTerm(kind="disputed")], "ends after term 2"),
        ([QueryTerm(kind="and", operands=4_000_000_000)], "ends after term 1"),
        ([QueryTerm(kind="not")], "ends after term 1"),
        ([QueryTerm(kind="disputed"), QueryTerm(kind="text", text="x")], "term 2 of the query, 'text'"),
        ([QueryTerm(kind="state", name="level", operator="~")], "term 1 of the query has the operator '~'"),
        ([QueryTerm(kind="not", operands=1)] * MAX_DEPTH + [QueryTerm(kind="disputed")], "nested deeper than 50"),
        ([QueryTerm(kind="disputed")] * (MAX_TERMS + 1), "1,001 terms; 1,000 is the limit"),
    ],
)
def test_invalid_terms_are_an_error_that_names_the_term(terms: list[QueryTerm], problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        read_terms(terms)
