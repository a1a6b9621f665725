"""Words of a query that match nothing in this house. Pure.

Queries are parsed without knowing the house, so a misspelt room or type is only noticed here.
"""

from collections.abc import Callable, Collection, Iterable, Sequence

from homebot.devices import Device
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.query.matching import fits
from homebot.devices.query.terms import (
    And,
    AreaIs,
    CanDo,
    FactIs,
    GatewayIs,
    HasText,
    InArea,
    NameIs,
    Or,
    Query,
    TypeIs,
    lasting,
    leaves,
)
from homebot.discovery.search.postings import Postings
from homebot.errors import RefusedError, UsageError
from homebot.places import OUTSIDE, HousePlan
from homebot.support.folding import fold, is_room_typo, is_typo, may_be_typo
from homebot.support.names import did_you_mean
from homebot.words.vocabulary import (
    ABILITIES,
    ADJECTIVES,
    CAPABILITY_WORDS,
    CONDITIONS,
    KEYWORDS,
    OWN_TEMPERATURE,
    TYPE_WORDS,
)

_SHOWN = 12
_TEMPERATURE = CanDo("temperature")
_PEOPLE = frozenset({"x_person", "x_household"})
_WORDS = frozenset({*TYPE_WORDS, *CAPABILITY_WORDS, *ABILITIES, *ADJECTIVES, *CONDITIONS, *KEYWORDS, "near", "within"})


def check_words(query: Query, postings: Postings, plan: HousePlan, devices: Callable[[], Iterable[Device]]) -> None:
    """Check that *query* has no misspelt word.

    Args:
        devices: Returns the devices, for the names of their parts.

    Raises:
        UsageError: A room is neither announced nor on the plan, which has others; or a type, room, name or word matches
            no device, but another is one typo away. The message says what was probably meant.
        RefusedError: A type does not exist, and no device has announced it.
    """
    for term in filter(_is_name, leaves(query)):
        if not postings.find(term) and (problem := _problem(term, postings, plan, devices)):
            raise UsageError(problem)


def _is_name(term: Query) -> bool:
    if isinstance(term, TypeIs):
        return term.by_word and not term.types
    return isinstance(term, InArea | AreaIs | NameIs | FactIs | GatewayIs | HasText)


def _problem(term: Query, postings: Postings, plan: HousePlan, devices: Callable[[], Iterable[Device]]) -> str:
    match term:
        case TypeIs(word):
            known = {*TYPE_WORDS, *postings.values_of("advertised")}
            problem = f"{word!r} is not a device type, and no device was announced as one"
            if misspelt := _typo(problem, word, known):
                return misspelt
            some = f"known are {', '.join(sorted(DEVICE_TYPES)[:_SHOWN])}, …"
            raise RefusedError("the query", f"{problem}; {did_you_mean(word, known, some)}")
        case InArea(area) | AreaIs(area) if area:
            return area_problem(area, postings, plan)
        case NameIs(name) | FactIs("name", name):
            return _unknown_name(name, postings, devices)
        case FactIs("tag", tag):
            return _typo(f"no device has the tag {tag!r}", tag, postings.values_of("tag"))
        case FactIs("group", group):
            hint = did_you_mean(group, postings.values_of("fact group"), "`homebot group list` shows all")
            return f"no device is in a group {group!r}; {hint}"
        case GatewayIs(gateway):
            return _typo(f"no device is reached through {gateway!r}", gateway, postings.values_of("gateway"))
        case FactIs("convention", convention):
            return _typo(f"no device was announced by {convention!r}", convention, postings.values_of("convention"))
        case HasText(word):
            return _typo(f"no device has the word {word!r}", word, _WORDS)
        case _:
            return ""


def _unknown_name(name: str, postings: Postings, devices: Callable[[], Iterable[Device]]) -> str:
    parts = (part.part.name for device in devices() for part in device.parts)
    known = {*postings.values_of("fact name"), *map(fold, parts)}
    meant = sorted(other for other in known if is_room_typo(name, other))
    is_known = any(f"{other} ".startswith(f"{name} ") for other in known)
    return f"nothing is called {name!r}; did you mean {' or '.join(meant)}?" if meant and not is_known else ""


def area_problem(area: str, postings: Postings, plan: HousePlan) -> str:
    """Return why *area*, a folded name, is not a place in the house; empty if it is or may become one."""
    rooms = [room.name for room in plan.rooms]
    stated = {fold(room): room for room in (*rooms, *plan.floors, plan.home)}
    known = {**{value: value for value in postings.values_of("area")}, **stated, fold(OUTSIDE): OUTSIDE}
    if any(f"{place} ".startswith(f"{area} ") for place in known):
        return ""
    if meant := sorted(known[place] for place in known if is_room_typo(area, place)):
        return f"no device is in {area!r}; did you mean {' or '.join(meant)}?"
    if not rooms:
        return ""  # its first device may still be announced
    hint = did_you_mean(area, known.values(), f"rooms are {', '.join(sorted(rooms)[:_SHOWN])}")
    return f"no device is in {area!r}, and [places] has no such room; {hint}"


def explain_result(
    query: Query, found: Collection[str], postings: Postings, plan: HousePlan, *, is_spelled: bool = False
) -> str:
    """Return why nothing matches *query*, or the words that the devices *found* only have with a typo; else empty.

    Args:
        is_spelled: Whether a typo or a beginning matched nothing.
    """
    words = (term for term in leaves(query) if isinstance(term, HasText))
    for term in words if is_spelled and not found else ():
        guessed = postings.find(term)
        if guessed and not any(fits(term, postings.facets(device_id)) for device_id in guessed):
            return f"no device has the word {term.text!r}; similar: {_names(guessed, postings)}"
    if not found:
        return _explain_none(query, postings, plan)
    long = {term.text for term in leaves(query) if isinstance(term, HasText) and may_be_typo(term.text)}
    near = sorted(
        word for word in long if not any(_begins(word, postings.facets(device_id).words) for device_id in found)
    )
    named = f"no device found has the word {' or '.join(map(repr, near))}; these have similar ones"
    return named if near else ""


def _begins(word: str, words: Iterable[str]) -> bool:
    return any(known.startswith(word) for known in words)


def _explain_none(query: Query, postings: Postings, plan: HousePlan) -> str:
    may = lasting(query)
    if any(_is_unknown_person(term, postings) for term in leaves(may)):
        return "nobody is known; add [people.NAME] with what tells where that person is"
    places = [term for term in leaves(may) if isinstance(term, InArea | AreaIs) and term.text]
    for place in places:
        if not postings.find(place):
            if problem := area_problem(place.text, postings, plan):
                return problem
            known = sorted(postings.values_of("area"))
            hint = f"areas are {', '.join(known[:_SHOWN])}"
            if not known:
                hint = "state the room of a device with `homebot place DEVICE ROOM`"
            return f"no device is in {place.text!r}; {did_you_mean(place.text, known, hint)}"
    if (able := postings.find(may)) and may != query:
        return f"none now; in another state there would be {_names(able, postings)}"
    if other := _explain_others(may, places, postings):
        return other
    return next(filter(None, (_missing(term, postings) for term in leaves(may) if not postings.find(term))), "")


def _explain_others(may: Query, places: Sequence[InArea | AreaIs], postings: Postings) -> str:
    """Return which devices fit all but one condition of *may*: what they measure, where they are, or what they can."""
    own = _with_each(may, lambda term: OWN_TEMPERATURE if term == _TEMPERATURE else term)
    if own != may and (measuring := postings.find(own)):
        return f"no thermometer is there; write 'local temperature' for that of {_names(measuring, postings)}"
    if places and (elsewhere := postings.find(_without(InArea, _without(AreaIs, may)))):
        return f"none is in {' or '.join([place.text for place in places])}; there is in {_rooms(elsewhere, postings)}"
    is_named = not {HasText, NameIs}.isdisjoint(map(type, leaves(may)))
    if is_named and (others := postings.find(_without(CanDo, may))):
        return f"what is called so has no such value: {_names(others, postings)}"
    return ""


def _is_unknown_person(term: Query, postings: Postings) -> bool:
    return isinstance(term, TypeIs) and bool(term.types & _PEOPLE) and not postings.find(term)


def _missing(term: Query, postings: Postings) -> str:
    """Return that no device has the word, name or tag in *term*, with the most similar; empty for other terms."""
    match term:
        case HasText(word):
            return f"no device has the word {word!r}"
        case NameIs(name) | FactIs("name", name):
            problem, key, known = f"nothing is called {name!r}", "names", postings.values_of("fact name")
        case FactIs("tag", name):
            problem, key, known = f"no device has the tag {name!r}", "tags", postings.values_of("tag")
        case _:
            return ""
    some = ", ".join(sorted(known)[:_SHOWN]) or "none"
    return f"{problem}; {did_you_mean(name, known, f'{key} are {some}')}"


def _rooms(devices: Iterable[str], postings: Postings) -> str:
    rooms = {area for device in devices for area in postings.facets(device).areas[:1]}
    return ", ".join(sorted(rooms)[:_SHOWN]) or "no room"


def _names(devices: Iterable[str], postings: Postings) -> str:
    names = sorted(postings.facets(device).name or device for device in devices)
    return f"{', '.join(names[:_SHOWN])}{', …' if len(names) > _SHOWN else ''}"


def _without(kind: type[Query], query: Query) -> Query:
    """Return *query* without its terms of a *kind*."""
    return _with_each(query, lambda term: And(()) if isinstance(term, kind) else term)


def _with_each(query: Query, changed: Callable[[Query], Query]) -> Query:
    """Return *query* with each of its terms *changed*."""
    match query:
        case And(terms) | Or(terms):
            return type(query)(tuple([_with_each(term, changed) for term in terms]))
        case _:
            return changed(query)


def _typo(problem: str, word: str, known: Collection[str]) -> str:
    meant = sorted(candidate for candidate in known if is_typo(word, candidate))
    return f"{problem}; did you mean {' or '.join(meant)}?" if meant and word not in known else ""
