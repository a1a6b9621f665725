"""Fields of automations, each of which is read once; a rest is refused. Pure.

All readers of this package raise :class:`NotCarriedError` for all that no routine can do or homebot does not know.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Final, NamedTuple, final

from homebot.errors import UsageError
from homebot.integrations.homeassistant.formats.jinja.syntax import nodes, tree_of
from homebot.integrations.homeassistant.formats.jinja.values import TemplateError
from homebot.support.located import Located

_TEMPLATE: Final = re.compile(r"\{[{%#]")
_TIME_OF_DAY: Final = re.compile(r"([01]?\d|2[0-3]):[0-5]\d(:[0-5]\d)?")
_CLOCK: Final = re.compile(r"(?P<sign>[+-]?)(?P<hours>\d+):(?P<minutes>\d{1,2})(?::(?P<seconds>\d{1,2}))?")
_EITHER: Final = re.compile(r"[+-]?[1-9]\d*:\d\d?")
"""Without quotation marks YAML 1.1, which Home Assistant reads, has 5:00 as a number to the base of 60."""

_DAYS: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_UNITS: Final = {"days": 86_400, "hours": 3600, "minutes": 60, "seconds": 1, "milliseconds": 0.001}
_FLAGS: Final = {
    **dict.fromkeys(("true", "yes", "on", "enable"), True),
    **dict.fromkeys(("false", "no", "off", "disable"), False),
}
_FOR_PEOPLE: Final = frozenset({"alias", "metadata", "continue_on_error"})
"""Keys that change nothing: a routine goes on after an error."""

_ADVICE: Final = {
    "duration": "; write the steps `wait 2m` and `off` after it",
    "flash": "; write the steps `toggle`, `wait 1s` and `toggle`",
    "profile": "; write `brightness_pct` and `color_temp_kelvin`",
    "response_variable": "; write an app, see docs/apps.md",
    "white": "; write `brightness_pct`",
    "date": "; write `datetime`, and `last run over 20h ago` for the last run",
    "timestamp": "; write `datetime`, and `last run over 20h ago` for the last run",
}
"""By the field: the text to write instead."""

_MAX_SHOWN_CHARACTERS: Final = 60


class NotCarriedError(UsageError):
    """A part of an automation without counterpart; the message names it, with the reason.

    Attributes:
        line: Its line; 0 for that of the trigger, condition or action that is read.
    """

    def __init__(self, problem: str, line: int = 0) -> None:
        super().__init__(problem)
        self.line = line


@final
class UnreadFields:
    """The fields of a mapping.

    Args:
        what: Its name in messages.

    Attributes:
        left: Those that are still to be read.
    """

    def __init__(self, node: Located, what: str) -> None:
        if node.tag or not isinstance(node.value, dict):
            raise _wrong(node, what, "has no fields")
        self._what = what
        self._line = node.line
        self.left: dict[str, Located] = {key: value for key, value in node.value.items() if key not in _FOR_PEOPLE}

    def __contains__(self, key: str) -> bool:
        return key in self.left

    def first_of(self, keys: Iterable[str]) -> str:
        """Return the first of *keys* that is there; empty if none is."""
        return next((key for key in keys if key in self.left), "")

    def end(self) -> None:
        """Check that all fields were read."""
        for key, node in self.left.items():
            raise NotCarriedError(
                f"{self._what}: `{key}` has no counterpart in routines{_ADVICE.get(key, '')}", node.line
            )

    def take(self, key: str) -> Located | None:
        """Return the value of *key*, which counts as read; None if it is missing."""
        return self.left.pop(key, None)

    def items(self, *keys: str) -> list[Located]:
        """Return the elements of the lists of *keys*, or values that stand for lists of one."""
        return [item for key in keys for item in items_of(self.take(key), key)]

    def inner(self, *keys: str) -> "UnreadFields":
        """Return the fields of *keys* together, any of which may be missing."""
        nodes = [node for key in keys if (node := self.take(key)) is not None and node.value is not None]
        together: dict[str, Located] = {}
        for node in nodes:
            together |= UnreadFields(node, keys[0]).left
        return UnreadFields(Located(together, self._line), keys[0])

    def flag(self, key: str, *, default: bool) -> bool:
        """Return a truth value, also as YAML 1.1 spells it: ``off`` and ``no``."""
        if (node := self.take(key)) is None:
            return default
        if (flag := _FLAGS.get(str(constant_of(node).value).casefold())) is None:
            raise _wrong(node, key, "is neither true nor false")
        return flag

    def text(self, key: str, default: str | None = None) -> str:
        """Return a text, or a number as text; without *default* it is an error if it is missing."""
        if (node := self.take(key)) is None:
            if default is None:
                raise NotCarriedError(f"{self._what}: `{key}` is missing", self._line)
            return default
        return _text(node, key)

    def texts(self, key: str) -> list[str]:
        """Return a list of texts, or a text with commas, as Home Assistant reads ids of entities."""
        return [part.strip() for item in self.items(key) for part in _text(item, key).split(",") if part.strip()]

    def texts_of(self, key: str) -> list[str]:
        """Return a list of texts that stays unread."""
        texts = self.texts(key) if (node := self.left.get(key)) is not None else []
        if node is not None:
            self.left[key] = node
        return texts

    def numbers(self, key: str) -> list[float]:
        """Return a list of numbers, or one number; empty if it is missing."""
        return [_number(item, key) for item in self.items(key)]

    def clock_times(self, key: str) -> list[str]:
        """Return a list of times of day, or one; empty if it is missing."""
        return [_clock_time(item, key) for item in self.items(key)]

    def days(self) -> str:
        """Return the days of the week of ``weekday`` as a condition: ``on mon,tue``; empty for none."""
        is_given, days = "weekday" in self, [text.casefold() for text in self.texts("weekday")]
        if (wrong := {*days} - {*_DAYS}) or (is_given and not days):  # without a day it never holds
            raise NotCarriedError(f"weekday: {min(wrong, default='')!r} is no day such as mon or tue", self._line)
        return f"on {','.join(day for day in _DAYS if day in days)}" if days else ""

    def duration(self, key: str) -> str:
        """Return a length of time as homebot spells it, with its sign: ``5m``; empty for none."""
        seconds = 0.0 if (node := self.take(key)) is None else _seconds(node, key)
        minutes, rest = divmod(round(abs(seconds), 3), 60)
        parts = zip("hms", (*divmod(minutes, 60), rest), strict=True)
        return ("-" if seconds < 0 else "") + "".join(f"{count:.10g}{unit}" for unit, count in parts if count)


class CalledService(NamedTuple):
    """The call of a service.

    Attributes:
        entities: The ids that it names, in its target, its data or beside it.
    """

    name: str
    entities: list[str]
    data: UnreadFields


def service_name(fields: Mapping[str, Located]) -> str:
    """Return the service that the action *fields* calls; empty for another action."""
    return next((str(fields[key].value) for key in ("service", "action") if key in fields), "")


def called_service(fields: Mapping[str, Located]) -> CalledService:
    """Return the call of a service that the action *fields* is, which stay unread.

    Raises:
        NotCarriedError: Its fields have no names.
    """
    call = UnreadFields(Located(dict(fields), 0), "action")
    data = call.inner("data", "data_template", "service_data")
    ids = [text for place in (call.inner("target"), data, call) for text in place.texts("entity_id")]
    return CalledService(service_name(fields), ids, data)


def items_of(node: Located | None, what: str) -> list[Located]:
    """Return the elements of a list, also of lists in it, or a value that stands for a list of one."""
    if node is None or node.value is None:
        return []
    node = constant_of(node)
    if node.tag:
        raise _wrong(node, what, "is not here")
    return [inner for item in node.value for inner in items_of(item, what)] if isinstance(node.value, list) else [node]


def constant_of(node: Located) -> Located:
    """Return *node* with the list or truth value that its template is by itself."""
    if not isinstance(node.value, str) or not node.value.lstrip().startswith("{{"):
        return node
    try:
        output = tree_of(node.value.strip()).body
        parts = output[0].nodes if len(output) == 1 and isinstance(output[0], nodes.Output) else []
        is_value = len(parts) == 1 and isinstance(parts[0], nodes.List | nodes.Tuple | nodes.Const)
        value = parts[0].as_const() if is_value else None
    except (TemplateError, nodes.Impossible):
        return node
    if isinstance(value, list | tuple):
        return node._replace(value=[_located(inner, node.line) for inner in value])
    return node._replace(value=value) if isinstance(value, bool) else node


def _located(value: object, line: int) -> Located:
    if isinstance(value, dict):
        return Located({str(key): _located(inner, line) for key, inner in value.items()}, line)
    if isinstance(value, list | tuple):
        return Located([_located(inner, line) for inner in value], line)
    return Located(value, line)


def walk(node: Located) -> Iterator[dict[str, Located]]:
    """Yield all mappings in *node*."""
    if isinstance(node.value, dict):
        yield node.value
    for inner in node.value.values() if isinstance(node.value, dict) else items_of(node, "") if not node.tag else ():
        if inner is not node:
            yield from walk(inner)


def shown(node: Located) -> str:
    """Return a value for a message."""
    text = repr(_plain(node))
    return text if len(text) <= _MAX_SHOWN_CHARACTERS else f"{text[:_MAX_SHOWN_CHARACTERS]}…"


def _wrong(node: Located, what: str, problem: str) -> NotCarriedError:
    """Return the error for a value, which says so if it stands in another file, or is a template."""
    if node.tag:
        return NotCarriedError(f"{node.tag} {shown(node)}: write the value itself there", node.line)
    if isinstance(node.value, str) and _TEMPLATE.search(node.value):
        return NotCarriedError(f"{what}: a template, {shown(node)}; routines have none", node.line)
    return NotCarriedError(f"{what}: {shown(node)} {problem}", node.line)


def _text(node: Located, what: str) -> str:
    value = node.value
    is_text = isinstance(value, str) and not _TEMPLATE.search(value)
    if node.tag or not (is_text or (isinstance(value, int | float) and not isinstance(value, bool))):
        raise _wrong(node, what, "is not a text")
    return str(value).strip()


def _number(node: Located, what: str) -> float:
    text = _text(node, what)
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise _wrong(node, what, "is not a number")
    return number


def _clock_time(node: Located, what: str) -> str:
    text = _text(node, what)
    if not _TIME_OF_DAY.fullmatch(text):
        raise _wrong(node, what, "is no time of day")
    return text.removesuffix(":00") if text.count(":") > 1 else text


def _seconds(node: Located, what: str) -> float:
    if isinstance(node.value, dict):
        fields = UnreadFields(node, what)
        total = sum(number * length for unit, length in _UNITS.items() for number in fields.numbers(unit))
        fields.end()
        return total
    text = _text(node, what)
    if _EITHER.fullmatch(text):
        raise _wrong(node, what, "may be minutes or hours; write it as hh:mm:ss")
    if (clock := _CLOCK.fullmatch(text)) is None:
        return _number(node, what)
    hours, minutes, seconds = (int(clock[unit] or 0) for unit in ("hours", "minutes", "seconds"))
    return (-1 if clock["sign"] == "-" else 1) * (3600 * hours + 60 * minutes + seconds)


def _plain(node: Located) -> object:
    if isinstance(node.value, dict):
        return {key: _plain(value) for key, value in node.value.items()}
    return [_plain(value) for value in node.value] if isinstance(node.value, list) else node.value
