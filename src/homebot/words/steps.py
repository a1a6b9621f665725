"""The steps of a routine, as text. Pure."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain
from typing import Final, Literal, TypeAlias

from homebot.devices.capabilities import CAPABILITIES, SETTABLE
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.query.terms import Query
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.support.names import did_you_mean
from homebot.support.numbers import to_number
from homebot.words.amounts import read_amount, split_commands
from homebot.words.colors import COLORS, WHITES
from homebot.words.commands import STATE_WORDS, check_without_code, is_relative
from homebot.words.message_values import MessageValue, read_message, with_values
from homebot.words.mistakes import read_in_any_language
from homebot.words.own_language import TextKind, to_english
from homebot.words.phrases import (
    DIM,
    DRIVE,
    HUE,
    MEANT_STEPS,
    NOTIFY,
    OVER,
    SCENE,
    SWITCH_ROUTINE,
    WAIT,
    WAIT_FOR,
    WAIT_UNTIL,
)
from homebot.words.queries import parse_query
from homebot.words.times import read_duration
from homebot.words.tokens import replaced, split_at, split_steps
from homebot.words.triggers import Becomes, Press, Trigger, read_press, read_state, read_trigger

MAX_LINES: Final = 50
"""The limit of the steps, triggers and conditions of a routine, each."""

MAX_ROUNDS: Final = 100
MAX_TURNS: Final = 100
"""The limit of devices of a loop over devices."""

IT: Final = "it"
"""The device in turn."""

MAX_RUNS: Final = 10
"""The runs of a routine that run or wait, unless it says another number."""

APPLY: Final = "apply"
"""The command to a scene."""

_UNITS: Final = {"%": "level", "k": "color_temperature", **dict.fromkeys(("", "c", "f", "°c", "°f"), "")}
"""The units of numbers, with the capabilities that they mean."""

_DEGREES: Final = frozenset({"°C", "C", "°F", "F"})

_WHAT: Final = "say what to do, such as on, off, open or 40 %; a device's own words follow a colon, as in 'washer: eco'"
_HOW_LONG: Final = "write it like 'wait 5m' or 'wait until hall motion clear, at most 30m'"
_HINTS: Final = {
    **dict.fromkeys(("wait", "delay", "pause", "sleep"), _HOW_LONG),
    **dict.fromkeys(("turn", "switch", "set"), "write the device first, like 'hall lamp on' or 'heater to 21 °C'"),
    "notify": "write it like 'notify The door is open'",
    "scene": "write it like 'scene Film'",
    **dict.fromkeys(
        ("dim", "brighten", "darken"), "write it like 'hall lamp 20 %' or 'hall lamp dim while hall button hold'"
    ),
    **dict.fromkeys(("go", "goto", "drive", "send"), "write it like 'robot go to kitchen'"),
    "repeat": "write it like '3 times: hall lamp toggle; wait 1s' or 'repeat while door open: wait 5m'",
    "for": "write it like 'for each open window: notify {name of it} is open'",
    "if": "write it like 'if sun is down: hall lamp on, else: hall lamp off'",
}
"""By the first word."""

RoutineSwitch: TypeAlias = Literal["enable", "disable", "run"]
_CHANGES: Final[Mapping[str, RoutineSwitch]] = {"on": "enable", "off": "disable", "run": "run", "start": "run"}
_ALIKE: Final = 0.7
_WORDS: Final = frozenset(
    chain(
        ("toggle", "turn on", "turn off"),
        STATE_WORDS,
        COLORS,
        WHITES,
        *((*one.words, *(one.options or ())) for one in CAPABILITIES.values()),
    )
)
_SETTABLE: Final = frozenset(
    word for one in CAPABILITIES.values() for word in (one.name, one.name.replace("_", " "), one.spoken) if word
) - frozenset(fold(word) for one in DEVICE_TYPES.values() for word in one.words)
"""Names of capabilities, but not those that are also names of devices, as in ``robot vacuum dock``."""
_MAX_COMMAND: Final = 100
"""Characters of the words of a command; a device's own may be longer, after a colon."""


@dataclass(frozen=True, slots=True)
class Do:
    """A command to all devices that *target* means.

    Attributes:
        values: Further values by capability, as text.
        transition: Seconds that the change takes, if a device supports that.
        pieces: The text with values of the house, which are known when it is taken; empty for one without them.
    """

    text: str
    target: str
    command: str
    values: tuple[tuple[str, str], ...] = ()
    transition: float = 0.0
    pieces: tuple[str | MessageValue, ...] = ()


@dataclass(frozen=True, slots=True)
class Dim:
    """A change of the level while a button is held.

    Attributes:
        query: The query of *target*.
        way: ``brighten``, ``darken``, or ``dim`` for away from the nearer end.
        held: The event of the button while it is held; any other one ends the step.
    """

    text: str
    target: str
    query: Query
    way: str
    held: Press


@dataclass(frozen=True, slots=True)
class SendRobot:
    """A drive of a robot to a room or into its dock; ``robot`` is the only robot."""

    text: str
    robot: str
    room: str

    @property
    def is_to_dock(self) -> bool:
        """True if it returns to its dock."""
        return self.room == "dock"


@dataclass(frozen=True, slots=True)
class Notify:
    """A message to people.

    Attributes:
        pieces: The text with values that are known when it is sent; empty for a text without them.
    """

    text: str
    pieces: tuple[str | MessageValue, ...] = ()


@dataclass(frozen=True, slots=True)
class Wait:
    """A pause, in seconds.

    Attributes:
        most: The end of the span from which its length is drawn; 0 for a fixed one.
        pieces: As those of :class:`Do`.
    """

    seconds: float
    most: float = 0.0
    pieces: tuple[str | MessageValue, ...] = ()


@dataclass(frozen=True, slots=True)
class WaitUntil:
    """A wait until a device is in a state, at most so many seconds.

    Attributes:
        stops: Whether the run is over if that has not come.
        others: Further states, which must be at the same time.
    """

    state: Becomes
    most: float
    stops: bool = False
    others: tuple[Becomes, ...] = ()

    @property
    def states(self) -> tuple[Becomes, ...]:
        """All states that it waits for."""
        return self.state, *self.others


@dataclass(frozen=True, slots=True)
class WaitFor:
    """A wait for the next of *triggers*, at most so many seconds.

    Attributes:
        stops: Whether the run is over without it.
    """

    text: str
    triggers: tuple[Trigger, ...]
    most: float
    stops: bool = False

    @property
    def texts(self) -> list[str]:
        """The texts of the triggers."""
        return split_at(self.text, "or") if len(self.triggers) > 1 else [self.text]


@dataclass(frozen=True, slots=True)
class Undo:
    """The values from before the earlier steps, where they have not been changed since."""


@dataclass(frozen=True, slots=True)
class Stop:
    """The end of the run."""


@dataclass(frozen=True, slots=True)
class SwitchRoutine:
    """A routine begins, or ceases, to watch for its triggers, or runs now, whatever its conditions."""

    text: str
    name: str
    change: RoutineSwitch


Step: TypeAlias = Do | Dim | SendRobot | Notify | Wait | WaitUntil | WaitFor | Undo | Stop | SwitchRoutine


class _NoStepError(UsageError):
    """A text that ends with no command."""


@lru_cache(maxsize=2000)  # read for each check of each routine
def read_step(text: str) -> Step:
    """Return the step *text*.

    Raises:
        UsageError: It is none; the message shows how it could be written.
    """
    return read_in_any_language(" ".join(text.split()), "step", _read_step)


def in_turn(text: str, kind: TextKind, devices: str) -> str:
    """Return the step or condition *text* with the query *devices* for each ``it``; in a message in its values only."""
    text = to_english(" ".join(text.split()), kind) or text
    if kind == "step" and NOTIFY.match(text):
        return with_values(text, lambda value: replaced(value, IT, devices))
    return replaced(text, IT, devices)


def _read_step(plain: str) -> Step:
    if "{" in plain and not NOTIFY.match(plain):
        return _read_filled(plain)
    try:
        return _read(plain)
    except _NoStepError as exc:
        if advice := _several(plain) or _meant(plain):
            raise UsageError(f"{plain!r}: {advice}") from exc
        raise


EXAMPLES: Final = {"now": "2000-01-01 00:00:00", "time": "00:00"}
"""What stands for values while a step is read, by their kinds; others are 1."""


def _read_filled(plain: str) -> Step:
    """Return a step with values of the house, as it would be with an example of each.

    Raises:
        UsageError: It is no command or pause, or one of the values is no number.
    """
    pieces = read_message(plain)
    for piece in pieces:
        if not isinstance(piece, str) and not piece.is_number and piece.kind not in EXAMPLES:
            raise UsageError(
                f"{plain!r}: {{{piece.text}}} is no number; a step has only numbers of the house, and {{now}}"
            )
    step = read_step("".join(piece if isinstance(piece, str) else EXAMPLES.get(piece.kind, "1") for piece in pieces))
    match step:
        case Do(target=target, command=command) if command != APPLY and plain.startswith(target):
            return replace(step, text=plain, pieces=pieces)
        case Wait():
            return replace(step, pieces=pieces)
    raise UsageError(f"{plain!r}: only commands, pauses and messages have values of the house")


def _read(plain: str) -> Step:
    if plain.casefold() == "undo":
        return Undo()
    if plain.casefold() == "stop":
        return Stop()
    if (message := NOTIFY.match(plain)) is not None:
        return Notify(message["text"], read_message(message["text"]))
    if (wait := _read_wait(plain)) is not None:
        return wait
    if (driven := DRIVE.match(plain)) is not None:
        return SendRobot(plain, driven["robot"].casefold(), driven["room"].strip('"'))
    if (held := DIM.match(plain)) is not None:
        target, way, button, event = held.values()
        if (press := read_press(f"{button} press {event}")) is not None:
            return Dim(plain, target, parse_query(target), way.casefold(), press)
    if (switch := SWITCH_ROUTINE.match(plain)) is not None:
        return SwitchRoutine(plain, switch["name"].strip("\"'"), _CHANGES[switch["way"].casefold()])
    if (scene := SCENE.match(plain)) is not None:
        length = read_duration(scene["length"], plain, "s") if "length" in scene else 0.0
        return Do(plain, f"scene {scene['name']}", APPLY, transition=length)
    return _read_do(plain)


def _read_wait(plain: str) -> Wait | WaitUntil | WaitFor | None:
    if (until := WAIT_UNTIL.match(plain)) is not None:
        stops = until.get("end", "").casefold() == "stop"
        *parts, last = split_at(until["state"], "until")
        if not all(part.casefold().endswith(" and") for part in parts):
            raise UsageError(f"{plain!r}: write several states like 'wait until X and until Y, at most 30m'")
        state, *others = (read_state(part) for part in (*(part[: -len(" and")] for part in parts), last))
        return WaitUntil(state, read_duration(until["most"], plain), stops, tuple(others))
    if plain.casefold().startswith("wait until"):
        raise UsageError(f"{plain!r} may last forever; write '{plain}, at most 30m'")
    if (awaited := WAIT_FOR.match(plain)) is not None:
        stops = awaited.get("end", "").casefold() == "stop"
        return WaitFor(awaited["what"], read_triggers(awaited["what"]), read_duration(awaited["most"], plain), stops)
    if (pause := WAIT.match(plain)) is not None:
        length, most = (read_duration(pause[key], plain, "s") if pause.get(key) else 0.0 for key in ("length", "most"))
        if "most" in pause and most <= length:
            raise UsageError(f"{plain!r}: the longest wait must be longer than the shortest")
        return Wait(length, most)
    return None


def read_triggers(text: str) -> tuple[Trigger, ...]:
    """Return the triggers in *text*, joined by ``or``.

    Raises:
        UsageError: A part of it is no trigger.
    """
    parts = split_at(text, "or")
    try:
        return tuple(map(read_trigger, parts))
    except UsageError:
        with suppress(UsageError):
            return (read_trigger(text),)
        raise


def _read_do(text: str) -> Do:
    """Return the command *text*: words for devices, and then words that devices take, such as ``hall lamp on, 20 %``.

    A colon divides them where the words of the command are a device's own: ``washing machine: eco 40``.
    """
    check_without_code(text)
    target, colon, command = text.partition(": ")
    if colon:
        return Do(text, target.strip(), command.strip())
    words = text.split(" ")
    for place in range(1, len(words)):
        target, rest = " ".join(words[:place]), " ".join(words[place:])
        commands = [command.removeprefix("to ") for command in split_commands(rest)]
        beginnings = (f"{target} {words[place]}", f"{target} {commands[0]}")
        if _are_commands(commands) and target[-1] != "," and not any(map(_is_no_target, beginnings)):
            if len(split_steps(target)) > 1 and _several(text):
                break
            is_after = place > 1 and words[place - 2].casefold() not in {"are", "is"}
            if is_after and words[place - 1].casefold() in {"on", "off"}:
                raise UsageError(f"{text!r}: write a comma after {words[place - 1]!r}, like '{target}, {rest}'")
            return _combined(text, target, commands)
    hint = _HINTS.get(words[0].casefold()) or did_you_mean(words[-1].casefold(), sorted(_WORDS), _WHAT, _ALIKE)
    raise _NoStepError(f"{text!r} is no step: it ends with no command; {hint}")


def _several(text: str) -> str:
    """Return the advice to divide *text* if it is several steps; else empty."""
    first, *others = split_steps(text)
    if not others:
        return ""
    try:
        device = _read_do(first).target
        parse_query(device)
        steps = [first, *(f"{device} {one}" if _is_command(one) else one for one in others)]
        for one in steps:
            _read(one)
    except UsageError:
        return ""
    return "" if device.endswith((" are", " is")) else f"write each as a step: {_listed(steps)}"


def _meant(text: str) -> str:
    """Return the advice of the first row of known mistakes that *text* is; empty if it is none.

    Raises:
        UsageError: The steps would have another mistake.
    """
    for form, advice, steps in MEANT_STEPS:
        if (found := form.match(text)) is not None:
            length = found.get("length", "")
            words = {**found, "length": f"{length}s" if length[-1:].isdigit() else length}
            written = [one.format(**words) for one in steps]
            for one in written:
                _read(one)
            return f"{advice} {_listed(written)}"
    return ""


def _listed(steps: Sequence[str]) -> str:
    *first, last = map(repr, steps)
    return f"{', '.join(first)} and {last}" if first else last


def _is_no_target(text: str) -> bool:
    """Return whether a target and a word after it are not meant so, as in ``turn …`` or ``… for 5m``."""
    words = text.casefold().split(" ")
    is_verb = words[0] == "turn" or (words[0] in {"bring", "send", "set"} and "to" in words[2:])
    return is_verb or words[-2] in {"and", "at", "for", "over", "then", "with"}


def _are_commands(texts: Sequence[str]) -> bool:
    """Return whether each of *texts* is a command, or but for the first the length of the change, as ``over 5s``."""
    return _is_command(texts[0]) and all(_is_command(text) or OVER.match(text) for text in texts)


def _is_command(text: str) -> bool:
    if len(text) > _MAX_COMMAND:
        return False
    word = text.casefold()
    if word in _WORDS or word.replace(" ", "_") in _WORDS or _hue_of(word):
        return True
    if _is_number(word) or (word.startswith(("brighter", "darker")) and is_relative(word)):
        return True
    words = word.removeprefix("set ").split(" ")
    return any(_is_setting(" ".join(words[:place]), " ".join(words[place:])) for place in range(1, len(words)))


def _is_setting(name: str, value: str) -> bool:
    """Return whether *name* is what a command sets, to *value*."""
    if name not in _SETTABLE or (name in _WORDS and value in _WORDS):  # as in ``kitchen heat off``
        return False
    is_set = name.replace(" ", "_") in SETTABLE  # not heat, as in ``kitchen heat to 16 °C``
    return " " not in value or value in _WORDS or (is_set and _is_number(value.removeprefix("to ")))


def _combined(text: str, target: str, commands: list[str]) -> Do:
    """Return one command for several words: ``on, 20 %, 2700 K``."""
    first, *others = commands
    command = first
    values: list[tuple[str, str]] = []
    over = OVER.match(others[-1]) if others else None
    transition = read_duration(over["length"], text, "s") if over is not None else 0.0
    others = others[:-1] if over is not None else others
    for one in others:
        if hue := _hue_of(one):
            values.append(("color", hue))
            continue
        number = read_amount(one)
        if number and number.unit in _DEGREES and not read_amount(first):
            command = f"{command}, {one}"  # which setpoint it is depends on the device
            continue
        capability = _UNITS.get(number.unit.casefold(), "") if number else _color_of(one)
        if OVER.match(one):
            raise UsageError(f"{text!r}: write {one!r} last")
        if not capability:
            raise UsageError(f"{text!r}: {one!r} cannot follow {first!r}; write it as a step of its own")
        values.append((capability, one))
    return Do(text, target, command, tuple(values), transition)


def _is_number(text: str) -> bool:
    number = read_amount(text)
    return number is not None and number.unit.casefold() in _UNITS


def _hue_of(text: str) -> str:
    """Return the hue in degrees and the saturation in per cent of the colour *text*; empty for none."""
    hue = HUE.match(text)
    return (
        hue["value"]
        if hue
        and [number is not None for number in map(to_number, hue["value"].replace(",", " ").split())] == [True, True]
        else ""
    )


def _color_of(word: str) -> str:
    return "color_temperature" if word in WHITES else "color" if word in COLORS else ""
