"""The ranking of devices that match a query, with reasons. Pure."""

from collections.abc import Iterable, Iterator
from collections.abc import Set as AbstractSet
from functools import lru_cache
from typing import TypeAlias

from homebot.devices.query.facets import Facets
from homebot.devices.query.matching import fits, matches_kind
from homebot.devices.query.terms import (
    And,
    AreaIs,
    CanDo,
    FactIs,
    FreshnessIs,
    HasText,
    InArea,
    NameIs,
    Not,
    Or,
    PartIs,
    Query,
    StateIs,
    TypeIs,
)
from homebot.devices.value import PlainValue
from homebot.discovery.search.postings import Postings
from homebot.support.folding import is_typo, words_of

Ranked: TypeAlias = tuple[float, str]
"""Score and id."""

_FRESHNESS = {"fresh": (1.0, "it reported recently"), "unconfirmed": (0.0, "it has not sent a message yet")}
_STALE = (-4.0, "it is stale: it has been silent for too long")
_OFFLINE = (-2.0, "it is offline")
_GUESSED = (-1.0, "its type was guessed")


def rank(query: Query, found: Iterable[str], postings: Postings) -> list[Ranked]:
    """Return the devices *found* by *query*, best first, equals sorted by id."""
    terms = tuple(_terms(query))
    scored = []
    for device_id in found:
        facets = postings.facets(device_id)
        points = [score for score, _ in _status_scores(facets)]
        points += [_weigh(term, facets)[0] for term in terms]
        scored.append((-sum(points), device_id))
    return [(-score, device_id) for score, device_id in sorted(scored)]


def shortcomings(query: Query, facets: Facets) -> list[tuple[float, str]]:
    """Return for each reason by how many points a match of *query* is below the maximum."""
    (freshness, why), *others = _status_scores(facets)
    worse = [(_FRESHNESS["fresh"][0] - freshness, why), *((-score, why) for score, why in others)]
    return [shortcoming for shortcoming in (*worse, *_unfitness(query, facets)) if shortcoming[0] > 0]


def least_shortcoming(found: AbstractSet[str], postings: Postings) -> float:
    """Return for each device in *found* by how many points its freshness alone puts it below the maximum."""
    known = [freshness for freshness in _FRESHNESS if not found.isdisjoint(postings.find(FreshnessIs(freshness)))]
    best = max((_FRESHNESS[freshness][0] for freshness in known), default=_STALE[0])
    return _FRESHNESS["fresh"][0] - best


def _unfitness(query: Query, facets: Facets) -> list[tuple[float, str]]:
    match query:
        case And(terms):
            return [shortcoming for term in terms for shortcoming in _unfitness(term, facets)]
        case Or(terms):
            alternatives = [
                _unfitness(term, facets) for term in terms if isinstance(term, HasText) or fits(term, facets)
            ]
            return min(alternatives, key=lambda one: sum(points for points, _ in one), default=[])
        case _:
            score, why = _weigh(query, facets)
            return [(max(0.0, _FULL.get(type(query), 0.0) - score), why)]


def reasons(query: Query, device_id: str, postings: Postings) -> tuple[str, ...]:
    """Return the reasons why the device matches *query* and has its rank, most important first."""
    facets = postings.facets(device_id)
    scored: list[tuple[float, str]] = []
    for term in _terms(query):
        score, why = _weigh(term, facets)
        if isinstance(term, StateIs):
            value = postings.value(device_id, term)
            score, why = (1.0, f"{term.capability} is {_show(value)}") if value is not None else (0.0, "")
        if why:
            scored.append((score, why))
    scored += [status for status in _status_scores(facets) if status[1]]
    return tuple(dict.fromkeys(why for _, why in sorted(scored, key=lambda reason: -abs(reason[0]))))


def _terms(query: Query) -> Iterator[Query]:
    match query:
        case And(terms) | Or(terms):
            for term in terms:
                yield from _terms(term)
        case Not():
            return
        case _:
            yield query


_BEST = 3.0
_CALLED = 6.0
_IN_AREA = 2.0
_FULL: dict[type[Query], float] = {
    TypeIs: _BEST,
    AreaIs: _IN_AREA,
    InArea: _IN_AREA,
    CanDo: 1.0,
    HasText: 4.0,
    FactIs: 1.0,
}
"""The scores of terms that match completely; a name that contains the word does not score more."""


def _weigh(term: Query, facets: Facets) -> tuple[float, str]:
    match term:
        case TypeIs():
            return _weigh_type(term, facets)
        case HasText(word):
            return _weigh_text(word, facets)
        case AreaIs(area) | InArea(area) if area and fits(term, facets):
            return (_IN_AREA, f"it is in {area}") if area in facets.areas else (1.0, f"its room is {facets.areas[0]}")
        case CanDo(name) if fits(term, facets):
            return 1.0, f"it has {name}"
        case NameIs(name) | PartIs(name) if fits(term, facets):
            return _CALLED, f"it is called {name}"
        case FactIs(name, value) if fits(term, facets):
            return 1.0, f"its {name} is {value}"
        case _:
            return 0.0, ""


def _weigh_type(term: TypeIs, facets: Facets) -> tuple[float, str]:
    if facets.main_type in term.types:
        return _BEST, f"it is a {_plain(facets.main_type)}"
    if term.by_word and term.word in facets.advertised:
        return 2.5, f"it was announced as {term.word}"
    for kind in facets.kinds:
        if matches_kind(term, kind):
            return 2.0, f"a part of it is a {_plain(kind[0])}"
    if facets.possible_types and facets.possible_types == term.types:
        return 1.0, f"it may be a {term.word}"
    return 0.0, ""


def _weigh_text(word: str, facets: Facets) -> tuple[float, str]:
    name = words_of(facets.name)
    if name == (word,):
        return _CALLED, f"it is called {word}"
    if word in name:
        return 4.0, f"its name has {word}"
    if word in facets.words:
        return 3.0, f"{word} is in its facts"
    begun = [known for known in facets.words if known.startswith(word)]
    if begun:
        return 2.0, f"{min(begun)} begins with {word}"
    if any(_is_near(word, known) for known in facets.words):
        return 1.0, f"{word} is a near match"
    return 0.0, ""


_is_near = lru_cache(maxsize=4096)(is_typo)
"""Size of the cache: a house has few words, and many devices share them."""


def _status_scores(facets: Facets) -> Iterator[tuple[float, str]]:
    yield _FRESHNESS.get(facets.freshness, _STALE)
    if facets.reachable == "no":
        yield _OFFLINE
    if facets.is_guessed:
        yield _GUESSED


def _show(value: PlainValue) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case float():
            return f"{value:g}"
        case _:
            return str(value)


def _plain(service_type: str) -> str:
    return service_type.removeprefix("x_").replace("_", " ")
