"""Comparisons in a text query: ``level>50``, ``temperature < 18 °C``, ``gateway=mqtt``, ``model="E27 bulb"``. Pure."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import get_args

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.capability_type import CapabilityType
from homebot.devices.device_types import DEVICE_TYPES, wanted_types
from homebot.devices.query.terms import (
    FIELDS,
    And,
    CanDo,
    FactIs,
    GatewayIs,
    HasText,
    InArea,
    NameIs,
    Not,
    Operator,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
    type_is,
)
from homebot.devices.value import PlainValue
from homebot.errors import UsageError
from homebot.support.folding import fold, words_of
from homebot.support.names import did_you_mean, similar_to
from homebot.words.amounts import FLAGS, read_amount
from homebot.words.tokens import Token
from homebot.words.vocabulary import CAPABILITY_WORDS, CONDITIONS, FACTS, TYPE_WORDS

_ALIKE = 0.6
_FRESHNESS = ("fresh", "unconfirmed", "stale")
_CATEGORIES = ("config", "diagnostic")
_REACHABLE = {"yes": "yes", "true": "yes", "no": "no", "false": "no", "unknown": "unknown"}
_CONTACT = {"open": True, "closed": False}


def comparison(name: Token, operator: Token, value: Token) -> Query:
    """Return the query for ``name operator value``.

    Raises:
        UsageError: The name is unknown, or the value or operator does not fit it; the message names valid ones.
    """
    spelled = fold(name.text)
    sign = next(one for one in get_args(Operator) if one == operator.text)
    capability = CAPABILITY_WORDS.get(spelled) if name.kind == "word" else None
    if capability is not None and (spelled not in FIELDS or spelled == "text"):
        return _state(CAPABILITIES[capability], sign, value)
    if sign not in {"=", "!="}:
        raise UsageError(f"{name.text} {operator.text} {value.text}: {_not_ordered(spelled, name)}")
    field = FIELDS.get(spelled, "") if name.kind == "word" else ""
    found = _field(field, name, value)
    return Not(found) if sign == "!=" else found


def _not_ordered(spelled: str, name: Token) -> str:
    if spelled in FIELDS:
        return f"{name.text} cannot be ordered; compare it with = or !="
    numbers = "numbers are for example level, position and temperature"
    return f"{name.text} is not a capability; {did_you_mean(spelled, CAPABILITY_WORDS, numbers, _ALIKE)}"


def _state(capability: CapabilityType, operator: Operator, value: Token) -> StateIs | And:
    if capability.is_event:
        raise UsageError(
            f"{capability.name} is an event, and never a state of a device; ask for `with {capability.name}`, and "
            f"follow the devices for what happens"
        )
    wanted = _value(capability, value)
    if operator not in {"=", "!="} and not isinstance(wanted, float):
        raise UsageError(f"{capability.name} is not a number; compare it with = or !=")
    return StateIs(capability.name, operator, wanted)


def _value(capability: CapabilityType, value: Token) -> PlainValue:
    match capability.kind:
        case "bool":
            return _flag(capability, value)
        case "number":
            return _number(capability, value)
        case "text" | "":
            return _option(capability, value)
        case "numbers":
            hint = f"ask for `with {capability.name}`"
            raise UsageError(f"{capability.name} is several numbers, which cannot be compared; {hint}")


def _flag(capability: CapabilityType, value: Token) -> bool:
    flags = {**FLAGS, **_CONTACT} if capability.name == "contact" else FLAGS
    if (word := fold(value.text)) not in flags:
        raise UsageError(f"{capability.name} is true or false, not {value.text!r}")
    return flags[word]


def _number(capability: CapabilityType, value: Token) -> float:
    number = read_amount(value.text)
    if number is None or number.unit not in {"", capability.unit, capability.unit.removeprefix("°")}:
        unit = f" in {capability.unit}" if capability.unit else ""
        raise UsageError(f"{capability.name} is a number{unit}, not {value.text!r}")
    return float(number.number)


def _option(capability: CapabilityType, value: Token) -> str:
    word = fold(value.text)
    if capability.options and word not in {fold(one) for one in capability.options}:
        options = ", ".join(capability.options)
        raise UsageError(f"{capability.name} is one of {options}, not {value.text!r}")
    return word


def _field(field: str, name: Token, value: Token) -> Query:
    parse = _FIELDS.get(field)
    return FactIs(field or _fact(name), fold(value.text)) if parse is None else parse(name, value)


def _capability(value: Token, *, settable: bool) -> Query:
    capability = CAPABILITY_WORDS.get(fold(value.text))
    if capability is None:
        raise UsageError(f"{value.text!r} is not a capability")
    return CanDo(capability, settable=settable)


def _category(name: Token, value: Token) -> Query:
    if (word := fold(value.text)) not in _CATEGORIES:
        raise UsageError(f"{name.text} is {' or '.join(_CATEGORIES)}, not {value.text!r}")
    return FactIs("category", word)


def _fact(name: Token) -> str:
    fact = name.text.casefold()
    if name.kind == "text" or fact in FACTS:
        return fact
    known = {*FIELDS, *FACTS, *CAPABILITY_WORDS}
    hint = did_you_mean(fact, known, f"known are {', '.join(sorted(FIELDS))}, …", _ALIKE)
    raise UsageError(f"{name.text[:40]!r} at character {name.at} is unknown; {hint}")


def _reachable(name: Token, value: Token) -> Query:
    if (word := fold(value.text)) not in _REACHABLE:
        raise UsageError(f"{name.text} is yes, no or unknown, not {value.text!r}")
    return ReachableIs(_REACHABLE[word])


def _freshness(name: Token, value: Token) -> Query:
    if (word := fold(value.text)) not in _FRESHNESS:
        raise UsageError(f"{name.text} is one of {', '.join(_FRESHNESS)}, not {value.text!r}")
    return CONDITIONS[word]


def _type(value: Token) -> TypeIs:
    if value.text in DEVICE_TYPES:
        return TypeIs(value.text, frozenset({value.text}), by_word=False)
    if value.kind == "word" and not wanted_types(value.text) and fold(value.text) not in {"sensor", "sensors"}:
        similar = similar_to(fold(value.text), TYPE_WORDS, _ALIKE)
        if similar:
            raise UsageError(
                f"{value.text[:40]!r} at character {value.at} is not a device type; "
                f"did you mean {' or '.join(similar)}? If devices were announced as one, put it in quotation marks"
            )
    return type_is(value.text)


_NAME_BEGINS = partial(FactIs, "name")

_FIELDS: Mapping[str, Callable[[Token, Token], Query]] = {
    "area": lambda _, value: InArea(fold(value.text)),
    "name": lambda _, value: (NameIs if value.kind == "text" else _NAME_BEGINS)(fold(value.text)),
    "type": lambda _, value: _type(value),
    "freshness": _freshness,
    "reachable": _reachable,
    "can": lambda _, value: _capability(value, settable=True),
    "has": lambda _, value: _capability(value, settable=False),
    "text": lambda _, value: And(tuple(HasText(word) for word in words_of(value.text))),
    "gateway": lambda _, value: GatewayIs(value.text),
    "category": _category,
    "id": lambda _, value: FactIs("id", value.text.casefold()),
    "convention": lambda _, value: FactIs("convention", value.text.casefold()),
}
"""The fields that are not facts of the same name, with their parsers of name and value."""
