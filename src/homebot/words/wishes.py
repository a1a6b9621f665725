"""The wishes of a goal in words. Pure."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final, TypeAlias

from homebot.devices.query.terms import StateIs
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.support.names import did_you_mean, find_name, resolve_name
from homebot.words.commands import is_relative
from homebot.words.mistakes import read_in_any_language
from homebot.words.own_language import split_wishes, to_english
from homebot.words.people import AT_HOME
from homebot.words.phrases import (
    AT_VALUE,
    DOCKED,
    IN_ROOM,
    IS,
    LAST_ROOM,
    LIT,
    NUMBERED,
    ROOM,
    SCENE_WISH,
    STATE_WISH,
    THE,
    VERB_FIRST,
)
from homebot.words.steps import Do, SendRobot, read_step
from homebot.words.tokens import has_code
from homebot.words.vocabulary import ADJECTIVES

DOCK: Final = "dock"
"""The room of a wish for a robot in its dock."""

_AT_DOCK: Final = frozenset({"at", "in", "on"})
_OPPOSITES: Final = {"on": "off", "open": "closed", "locked": "unlocked", "lit": "dark"}
_OPPOSITE: Final = _OPPOSITES | {other: one for one, other in _OPPOSITES.items()}
_EVERYWHERE: Final = frozenset({"house", "home", "whole house", "everything"})
_COMMANDS: Final = {"closed": "close", "docked": "dock"}
_LIGHTS: Final = {"alight": "on", "unlit": "off"}
"""What is so of a room as of a lamp."""

_DONE: Final = {"close": "closed", "lock": "locked", "unlock": "unlocked"}
_STATES: Final = frozenset({*ADJECTIVES, *_LIGHTS, "lit", "dark"})
_ONCE: Final = frozenset({"toggle", "apply", "push", "press"})
_TYPO: Final = 0.7
_EXAMPLES: Final = "write it like 'kitchen lit', 'hall dark', 'rosie in kitchen', 'hall lamp on' or 'front door closed'"


@dataclass(frozen=True, slots=True)
class KnownNames:
    """The names in the house that a wish may have; ``areas`` are rooms and floors."""

    rooms: Collection[str] = ()
    areas: Collection[str] = ()
    robots: Collection[str] = ()
    scenes: Collection[str] = ()


@dataclass(frozen=True, slots=True)
class RobotCondition:
    """A robot is in a room, or in none but this one; ``room`` may be :data:`DOCK`."""

    text: str
    robot: str
    room: str
    is_not: bool = False


@dataclass(frozen=True, slots=True)
class RoomCondition:
    """One lamp of an area is on, or all are off; an empty area is the house."""

    text: str
    area: str
    is_lit: bool


@dataclass(frozen=True, slots=True)
class SceneCondition:
    """All parts are as a scene has them."""

    text: str
    scene: str


@dataclass(frozen=True, slots=True)
class StateCondition:
    """Parts are as after a command.

    Attributes:
        area: Whether *target* is a whole room.
        states: The states of the word; any of them is enough. Without any, all values of the command count.
    """

    text: str
    target: str
    command: str
    area: bool = False
    states: tuple[StateIs, ...] = ()


GoalCondition: TypeAlias = RobotCondition | RoomCondition | SceneCondition | StateCondition


def read_wishes(text: str, known: KnownNames) -> tuple[GoalCondition, ...]:
    """Return the wishes of the goal *text*.

    Raises:
        UsageError: A wish is not understood, or names no room or scene; the message suggests one.
    """
    if has_code(text):
        raise UsageError("a goal has no code, as it is journaled; give it before: homebot do LOCK unlock --ask-code")
    found = list(_wishes(" ".join(text.split()), known))
    if not found:
        raise UsageError(f"the goal is empty; {_EXAMPLES}")
    places: dict[str, RobotCondition] = {}
    for one in found:
        if not isinstance(one, RobotCondition) or one.is_not:
            continue
        if (other := places.setdefault(fold(one.robot), one)).room != one.room:
            raise UsageError(f"{one.robot} cannot be in {other.room} and in {one.room} at once")
    return tuple(dict.fromkeys(found))


def _wishes(text: str, known: KnownNames) -> Iterator[GoalCondition]:
    """Yield the wishes in *text*; a part that is left out is as in the neighbour.

    ``front door closed and locked`` has one subject, ``kitchen and living lit`` one state, and ``lights off in kitchen
    and hall`` both.

    Raises:
        UsageError: A wish is not understood.
    """
    parts = [part for text_part in split_wishes(text) if (part := text_part.removesuffix("."))]
    phrase = ""
    for number, part in enumerate(parts):
        later = [to_english(one, "wish") or one for one in parts[number + 1 :]]
        wish, phrase = read_in_any_language(part, "wish", partial(_wish_among, before=phrase, later=later, known=known))
        own = to_english(part, "wish")
        if own and isinstance(wish, StateCondition | RobotCondition):
            wish = replace(wish, text=phrase.replace(own, part))
        yield wish


def _wish_among(text: str, before: str, later: Sequence[str], known: KnownNames) -> tuple[GoalCondition, str]:
    """Return the wish *text*, and it with what it leaves out, between the one *before* and the *later* ones."""
    phrase, subject = text, before.rpartition(" ")[0]
    if fold(phrase) in ADJECTIVES and subject:
        phrase = f"{subject} {phrase}"
    elif _known_area(_without_the(text), known.areas) and (place := LAST_ROOM.match(before)) is not None:
        phrase = f"{place['what']} in {text}"
    try:
        return _wish(phrase, known), phrase
    except UsageError:
        states = (last for one in later if fold(last := one.rpartition(" ")[2]) in _STATES)
        if not (state := next(states, "")):
            raise
        return _wish(f"{text} {state}", known), phrase


def _wish(text: str, known: KnownNames) -> GoalCondition:
    plain = _without_the(text)
    if scene := _scene(plain, known.scenes):
        return SceneCondition(f"scene {scene}", scene)
    found = ((form.match(plain), wish) for form, wish in VERB_FIRST)  # such as `turn on the hall lamp`
    plain = next((wish.format(**values) for values, wish in found if values is not None), plain)
    first, _, rest = plain.partition(" ")
    is_not = fold(first) in {"no", "not"} and bool(rest)
    plain = _without_the(rest) if is_not else plain
    if (lit := LIT.match(plain)) is not None and (state := _LIGHTS.get(fold(lit["word"]), "")):
        place = _without_the(lit["room"])
        if not _known_area(place, known.areas) and fold(place) not in _EVERYWHERE:
            plain, lit = f"{lit['room']} {state}", None
    if lit is not None:
        is_lit = (fold(lit["word"]) not in {"dark", "unlit"}) ^ is_not ^ bool(lit["no"])
        area = "" if fold(lit["room"]) in _EVERYWHERE else _area(lit["room"], known.areas)
        return RoomCondition(f"{area or 'house'} {'lit' if is_lit else 'dark'}", area, is_lit)
    return _of_robot(text, plain, known, is_not=is_not) or _state(text, plain, known, is_not=is_not)


def _of_robot(text: str, plain: str, known: KnownNames, *, is_not: bool) -> RobotCondition | None:
    docked = DOCKED.match(plain)
    if docked is not None and not is_not and (docked["way"] in _AT_DOCK or find_name(docked["robot"], known.robots)):
        return RobotCondition(text, docked["robot"], DOCK)
    placed = IN_ROOM.match(plain)
    if placed is None or (not find_name(placed["room"], known.rooms) and _ends_with_state(plain)):
        return None
    return RobotCondition(
        text, placed["robot"], _area(placed["room"], known.rooms), is_not=is_not ^ bool(placed.get("no"))
    )


def _state(text: str, plain: str, known: KnownNames, *, is_not: bool) -> GoalCondition:
    found = STATE_WISH.match(plain)
    if found is not None and (state := fold(found["state"])) in ADJECTIVES:
        if is_not ^ bool(found["no"]):
            state = _OPPOSITE.get(state, "")
        if state:
            where = found.get("where", "house")
            everywhere = fold(_without_the(where)) in _EVERYWHERE
            return _of_parts(text, found["what"] if everywhere else f"{found['what']} in {where}", state, known)
    words = _without_at(plain)
    if is_not or " not " in fold(words):
        raise UsageError(f"{text!r}: what should be so instead is unclear; say that")
    try:
        step = read_step(words)
    except UsageError:
        first, _, last = words.rpartition(" ")
        missing = "names no state" if first else "names no device or no state"
        states = [*_OPPOSITE, *(one for one, (state, *_) in ADJECTIVES.items() if state.capability != AT_HOME)]
        hint = did_you_mean(last, states, _EXAMPLES, _TYPO) if first else _EXAMPLES
        raise UsageError(f"{text!r} {missing}; {hint}") from None
    match step:
        case SendRobot(robot=robot, room=room):
            return RobotCondition(text, robot, room if room == DOCK else _area(room, known.rooms))
        case Do(target=target, command=command, values=()) if not (fold(command) in _ONCE or is_relative(command)):
            return _of_parts(text, target, command, known)
    raise UsageError(f"{text!r} names no state that lasts; {_EXAMPLES}")


def _of_parts(text: str, target: str, command: str, known: KnownNames) -> StateCondition:
    target = being["what"] if (being := IS.match(target)) else target
    area = _known_area(target, known.areas)
    if area and (named := NUMBERED.match(command)) is not None:  # living heat 19
        area, target, command = "", f"{target} {named['rest']}", named["number"]
    if area and command in {"on", "off"}:
        lamps = f"lights in {area} {command}"
        raise UsageError(f"{text!r} would mean everything in it; say {f'{area} lit'!r}, or {lamps!r}")
    states = ADJECTIVES.get(_DONE.get(fold(command), fold(command)), ())
    return StateCondition(text, area or target, _COMMANDS.get(command, command), bool(area), states)


def _scene(text: str, scenes: Collection[str]) -> str:
    """Return the scene that *text* names; empty for none."""
    if (found := find_name(text, scenes)) or (named := SCENE_WISH.match(text)) is None:
        return found
    return resolve_name("scene", named["name"].strip('"'), scenes, "`homebot scene list` shows all")


def _area(name: str, areas: Collection[str]) -> str:
    name = name.strip('"')
    return _known_area(name, areas) or resolve_name("room", name, areas)


def _known_area(name: str, areas: Collection[str]) -> str:
    """Return the area *name*, with or without the word room; empty for none."""
    found, room = find_name(name, areas), ROOM.match(name)
    return found or (find_name(room["name"], areas) if room else "")


def _without_the(text: str) -> str:
    found = THE.match(text)
    return found["what"] if found else text


def _without_at(text: str) -> str:
    """Return *text* without the words before a value, as in ``heater is set to 21``."""
    found = AT_VALUE.match(text)
    return f"{found['what']} {found['value']}" if found else text


def _ends_with_state(text: str) -> bool:
    try:
        read_step(_without_at(text))
    except UsageError:
        return False
    return True
