"""The words of text queries, other than device types, and their meanings. Pure."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from types import MappingProxyType

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES, wanted_types
from homebot.devices.names import UNREADABLE
from homebot.devices.query.terms import (
    And,
    CanDo,
    FactIs,
    FreshnessIs,
    IsDisputed,
    IsUnapproved,
    NameIs,
    Not,
    Or,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
    leaves,
    type_is,
)
from homebot.support.folding import fold

KEYWORDS = frozenset({"and", "or", "not", "in", "with", "without", "but"})

_FILLERS = """
the a an all any anything every everything each which what there device devices are is my of please
currently now turned switched
"""
FILLERS = frozenset(_FILLERS.split())
"""Words without meaning that turn a query into a sentence."""

RELATIVES = frozenset({"that"})
"""Words that are fillers before ``is`` and ``are``; ``that lamp`` means one that a person points to."""

FACTS = frozenset(
    {
        "configuration_url",
        "description",
        "firmware",
        "generation",
        "group",
        "home",
        "host_mac",
        "hostname",
        "hw_version",
    }
    | {"interview", "ip", "ip_address", "manufacturer", "mode", "model", "model_id", "origin", "origin_sw_version"}
    | {"origin_url", "power_source", "serial_number", "supported", "sw_version", "via_device", "zigbee_type"}
)
"""Facts with which devices are announced. Other names need quotation marks: ``"zone"=3``."""

NOT_UNDERSTOOD = frozenset(
    {"near", "nearest", "nearby", "closest", "around", "beside", "behind", "next", "outside", "inside", "within"}
    | {"above", "below", "under", "over", "more", "less", "than", "between", "before", "after", "since", "until"}
    | {"during", "at", "from", "by", "for", "to", "except", "unless", "else", "if"}
    | {"when", "where", "here", "who", "whose"}
)
"""Words that would change the meaning of a query if they were mistaken for parts of names."""

TYPE_WORDS = frozenset(
    form
    for one in DEVICE_TYPES.values()
    for word in (fold(one.name.removeprefix("x_")), *(fold(word) for word in one.words))
    for form in (word, f"{word}s")
) | frozenset(DEVICE_TYPES)
"""The words for device types."""


_PEOPLE = frozenset({"kelvin"})
"""Further names of capabilities that people have too: "lamp kelvin" is the one called so."""


def _capability_words() -> Mapping[str, str]:
    spoken = Counter(one.spoken for one in CAPABILITIES.values())
    own = {word for word, count in spoken.items() if word and count == 1} - _PEOPLE
    words = {fold(name): name for name in CAPABILITIES}
    words |= {one.spoken: name for name, one in CAPABILITIES.items() if one.spoken in own}
    words |= {
        "dimmer": "level",
        "colour": "color",
        "colour temperature": "color_temperature",
        "setpoint": "heating_setpoint",
        "co2": "carbon_dioxide",
        "lux": "illuminance",
        "on": "on_off",
        "pm2.5": "pm25",
        "rssi": "signal_strength",
        "voc": "volatile_organic_compounds",
    }
    return MappingProxyType(words)


CAPABILITY_WORDS: Mapping[str, str] = _capability_words()
"""The words for capabilities, folded."""

ABILITIES: Mapping[str, Query] = MappingProxyType(
    {
        "dimmable": CanDo("level", settable=True),
        "tunable": CanDo("color_temperature", settable=True),
        "colored": CanDo("color", settable=True),
        "coloured": CanDo("color", settable=True),
        "colorful": CanDo("color", settable=True),
        "switchable": CanDo("on_off", settable=True),
        "openable": Or(tuple(CanDo(one, settable=True) for one in ("position", "movement", "valve"))),
        "lockable": CanDo("lock", settable=True),
    }
)
"""Adjectives for settable capabilities."""

ADJECTIVES: Mapping[str, tuple[StateIs, ...]] = MappingProxyType(
    {
        "on": (StateIs("on_off", "=", True),),  # noqa: FBT003 - a value, not a switch
        "off": (StateIs("on_off", "=", False),),  # noqa: FBT003 - as above
        "open": (
            StateIs("contact", "=", True),  # noqa: FBT003 - as above
            StateIs("movement", "=", "open"),
            StateIs("valve", "=", "open"),
            StateIs("position", ">", 0.0),
            StateIs("lock", "=", "open"),
        ),
        "closed": (
            StateIs("contact", "=", False),  # noqa: FBT003 - as above
            StateIs("movement", "=", "closed"),
            StateIs("valve", "=", "closed"),
            StateIs("position", "=", 0.0),
        ),
        "opening": (StateIs("movement", "=", "opening"), StateIs("valve", "=", "opening")),
        "closing": (StateIs("movement", "=", "closing"), StateIs("valve", "=", "closing")),
        "locked": (StateIs("lock", "=", "locked"),),
        "unlocked": (
            StateIs("lock", "=", "unlocked"),
            StateIs("lock", "=", "open"),
            StateIs("unlocked", "=", True),  # noqa: FBT003 - as above
        ),
        "occupied": (StateIs("occupancy", "=", True),),  # noqa: FBT003 - as above
        "unoccupied": (StateIs("occupancy", "=", False),),  # noqa: FBT003 - as above
        "clear": (StateIs("occupancy", "=", False),),  # noqa: FBT003 - as above
        **dict.fromkeys(("at home", "is home", "are home"), (StateIs("at_home", "=", True),)),  # noqa: FBT003 - as above
        **dict.fromkeys(("away", "is not home", "is not at home"), (StateIs("at_home", "=", False),)),  # noqa: FBT003 - as above
        "wet": (StateIs("water_leak", "=", True),),  # noqa: FBT003 - as above
        "dry": (StateIs("water_leak", "=", False),),  # noqa: FBT003 - as above
        "jammed": (StateIs("lock", "=", "jammed"),),
        "cleaning": (StateIs("vacuum", "=", "cleaning"),),
        "playing": (StateIs("playback", "=", "playing"),),
        "docked": (StateIs("vacuum", "=", "docked"), StateIs("mower", "=", "docked")),
        "heating": (StateIs("thermostat_action", "=", "heating"),),
        "cooling": (StateIs("thermostat_action", "=", "cooling"),),
    }
)
"""Adjectives for a state: any of these values."""

HOUSEHOLD = TypeIs("household", frozenset({"x_household"}), by_word=False)
HOUSEHOLD_FACTS: Mapping[str, tuple[StateIs, StateIs]] = {
    **dict.fromkeys(
        ("somebody", "someone", "anybody", "anyone"),
        (StateIs("at_home", "=", True), StateIs("all_at_home", "=", False)),  # noqa: FBT003 - as above
    ),
    **dict.fromkeys(
        ("nobody", "no one"),
        (StateIs("at_home", "=", False), StateIs("all_at_home", "=", True)),  # noqa: FBT003 - as above
    ),
    **dict.fromkeys(
        ("everybody", "everyone"),
        (StateIs("all_at_home", "=", True), StateIs("at_home", "=", False)),  # noqa: FBT003 - as above
    ),
}
"""The fact that these people are at home, and that they are away."""

_WEAK = Or((StateIs("battery", "<", 20.0), StateIs("battery_low", "=", True)))  # noqa: FBT003 - as above

_DETECTED = {
    "carbon monoxide": "carbon_monoxide_alarm",
    "frost": "freeze",
    "tampering": "tamper",
    **dict.fromkeys(("leak", "moisture", "water", "water leak"), "water_leak"),
    **{name: name for name in ("gas", "heat", "rain", "smoke", "sound", "vibration")},
}
"""What sensors detect, as people say, with the capability."""

_SENSED = frozenset(name for name, one in CAPABILITIES.items() if one.kind == "bool" and not (one.is_set or one.words))
"""The capabilities that are detected or not, and never switched."""

CONDITIONS: Mapping[str, Query] = MappingProxyType(
    {
        **{f"{how} {what}": _WEAK for how in ("low", "weak") for what in ("battery", "batteries")},
        **{f"{what} low": _WEAK for what in ("battery", "battery is", "batteries", "batteries are")},
        **{f"who is {state}": And((type_is("person"), *ADJECTIVES[state])) for state in ("at home", "away")},
        "who is home": And((type_is("person"), *ADJECTIVES["at home"])),
        **{
            f"{word} {state}": StateIs(capability, "=", state == "detected")
            for word, capability in _DETECTED.items()
            for state in ("detected", "clear")
        },
        "fresh": FreshnessIs("fresh"),
        "stale": FreshnessIs("stale"),
        "unconfirmed": FreshnessIs("unconfirmed"),
        "reachable": ReachableIs("yes"),
        "online": ReachableIs("yes"),
        "unreachable": ReachableIs("no"),
        "offline": ReachableIs("no"),
        "disputed": IsDisputed(),
        "unapproved": IsUnapproved(),
        "unreadable": FactIs(UNREADABLE, "payloads"),
        **{
            f"{who} {place}": And((HOUSEHOLD, fact))
            for who, facts in HOUSEHOLD_FACTS.items()
            for fact, places in zip(facts, (("home", "at home"), ("away",)), strict=True)
            for plain in places
            for place in (plain, f"is {plain}")
        },
    }
)
"""Adjectives for the condition of a device, and for the facts of the household, which is one."""


OWN_TEMPERATURE = CanDo("local_temperature")
"""What a thermostat or an air conditioner measures itself."""


def meaning_of(phrase: str) -> Query | None:
    """Return the term for *phrase*, folded; None if it is not a query word."""
    if not phrase:
        return None
    if (meant := CONDITIONS.get(phrase) or ABILITIES.get(phrase)) is not None:
        return meant
    if (states := ADJECTIVES.get(phrase)) is not None:
        return states[0] if len(states) == 1 else Or(states)
    capability = CAPABILITY_WORDS.get(phrase)
    if wanted_types(phrase) or phrase in {"sensor", "sensors"}:
        named = type_is(phrase)
        own = (OWN_TEMPERATURE,) if capability == "temperature" else ()
        return named if capability is None else Or((named, CanDo(capability), *own))
    return None if capability is None else CanDo(capability)


def is_meaningful(word: str) -> bool:
    """Return whether *word*, folded, is a type or an adjective."""
    return word in ADJECTIVES or word in CONDITIONS or word in ABILITIES or bool(type_is(word).types)


def all_of(terms: list[Query]) -> Query:
    """Return the conjunction of *terms*, with adjectives applied to the types next to them."""
    if not any(isinstance(term, TypeIs | NameIs) for term in terms):
        terms = [_NOUNS.get(term, term) for term in terms]
    if any(term in _OF_LOCKS for term in terms):  # a locked door is one whose lock is
        terms = [Or((one, _LOCK)) if isinstance(one, TypeIs) and one.tag else one for one in terms]
    detections = _detections(terms)
    scoped = [_or_detected(term, detections) if detections else term for term in _with_scopes(terms)]
    return scoped[0] if len(scoped) == 1 else And(tuple(scoped))


def _detections(terms: list[Query]) -> dict[str, frozenset[str]]:
    """Return the detections of the sensors in *terms*, with their types; empty if a type or capability is another."""
    found: dict[str, frozenset[str]] = {}
    for term in terms:
        nouns = [] if isinstance(term, Not) else [*leaves(term)]
        types = frozenset(one for noun in nouns if isinstance(noun, TypeIs) for one in noun.types)
        names = {noun.name for noun in nouns if isinstance(noun, CanDo)}
        names = names or {name for name in _SENSED if CAPABILITIES[name].sensor in types}
        if (types and not names) or not names <= _SENSED:
            return {}
        found |= dict.fromkeys(names, types)
    return found


def _or_detected(term: Query, detections: Mapping[str, frozenset[str]]) -> Query:
    """Return *term* with ``on`` also as the detection of a sensor, or of a device without a switch."""
    match term:
        case StateIs("on_off", "=", value):
            states = [StateIs(name, "=", value, types) for name, types in detections.items()]
            alone = And((Not(CanDo("on_off")), Or(tuple(replace(state, types=frozenset()) for state in states))))
            return Or((term, *(state for state in states if state.types), alone))
        case Not(denied):
            return Not(_or_detected(denied, detections))
    return term


def _with_scopes(terms: list[Query]) -> list[Query]:
    whole = [
        leaves(term) for term in terms if isinstance(term, TypeIs) or (isinstance(term, Or) and _LOCK in term.terms)
    ]
    types = frozenset(one for term in chain(*whole) if isinstance(term, TypeIs) for one in term.types)
    return [_add_scope(term, types) for term in terms] if types else terms


def _add_scope(term: Query, types: frozenset[str]) -> Query:
    if term in _ADJECTIVE_TERMS:
        match term:
            case StateIs():
                return replace(term, types=types)
            case Or(terms):
                return Or(tuple(replace(one, types=types) for one in terms if isinstance(one, StateIs)))
    return Not(_add_scope(term.term, types)) if isinstance(term, Not) else term


_ADJECTIVE_TERMS = frozenset(states[0] if len(states) == 1 else Or(states) for states in ADJECTIVES.values())

_OF_LOCKS = frozenset(meaning_of(word) for word in ("locked", "unlocked", "jammed"))
_LOCK = type_is("lock")

_NOUNS: dict[Query, Query] = {
    states[0]: type_is(word) for word, states in ADJECTIVES.items() if len(states) == 1 and wanted_types(word)
}
"""Types for words such as ``heating`` that are also adjectives, if no type is next to them."""
