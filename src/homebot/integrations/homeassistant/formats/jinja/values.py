"""Values, errors and limits of templates from outside: look-up and text of each value in bounded work. Pure."""

from collections.abc import Iterator
from datetime import datetime
from typing import Final, NoReturn, final

from homebot.errors import WireError

MAX_SOURCE: Final = 8192
"""Longest source, in characters."""

MAX_TOKENS: Final = 1024
"""Most tokens of a source. Jinja's parser needs about 15 microseconds for each."""

MAX_DEPTH: Final = 64
"""Deepest nesting of brackets in a source, and of operations; far from Python's recursion limit."""

MAX_FOR_DEPTH: Final = 4
"""Deepest nesting of loops."""

MAX_STEPS: Final = 10_000
"""Most work of one rendering. A step is about a microsecond: an operation, four values of a list, or 256 characters."""

FREE_STEPS: Final = 100
"""Work that each rendering has beside one step for each of its nodes; what exceeds it, all that read a message share.

Of 886 templates of real devices 883 take less, and those others are alone on their topics."""

MAX_TEXT: Final = 65_536
"""Longest text, also the rendered one, in characters."""

MAX_ITEMS: Final = 4096
"""Most values in a list or mapping, with those in its items."""

MAX_NUMBER_BITS: Final = 256
"""Largest whole number in bits."""

MAX_NUMERAL: Final = 400
"""Longest text that is read as a number, in characters: any finite float has fewer digits."""


class TemplateError(WireError):
    """A template gives no text: it is unsupported, or fails with these values, or would do too much work."""


class UndefinedValueError(TemplateError):
    """A template uses a missing value; Jinja's ``UndefinedError``."""


class NotDefinedError(UndefinedValueError):
    """A message lacks a value that the template checks by ``is_defined``: it is for another reader, and no fault."""


class Undefined:
    """A missing value: false, empty and equal to its like, with an empty text.

    Arithmetic, order, and look-up in it raise :class:`UndefinedValueError`.

    Source: Jinja 3.1 documentation, Undefined Types, ``Undefined``.
    """

    __slots__ = ()

    def __str__(self) -> str:
        return ""

    def __repr__(self) -> str:
        return "Undefined"

    def __len__(self) -> int:
        return 0

    def __iter__(self) -> Iterator[object]:
        return iter(())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Undefined)

    def __hash__(self) -> int:
        return id(Undefined)

    def fail(self, *_: object) -> NoReturn:
        """Raise the error of every use of the value."""
        raise UndefinedValueError("a value that the template uses is not in the message")

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = fail
    __floordiv__ = __rfloordiv__ = __mod__ = __rmod__ = __pow__ = __rpow__ = __neg__ = __pos__ = fail
    __getitem__ = __lt__ = __le__ = __gt__ = __ge__ = __int__ = __float__ = fail


UNDEFINED = Undefined()


@final
class Namespace:
    """The result of ``namespace()``: the one value that a template may change."""

    __slots__ = ("attributes",)

    def __init__(self, attributes: dict[str, object]) -> None:
        self.attributes = attributes

    def __repr__(self) -> str:
        return "<Namespace>"


_TIME_PARTS = frozenset({"year", "month", "day", "hour", "minute", "second", "microsecond"})


def item(value: object, key: object) -> object:
    """Return the value at *key* in *value*: a key, an index, or a part of a time; UNDEFINED if there is none.

    Unlike in Jinja, attributes are not looked up: a field missing in a message is undefined.

    Raises:
        TemplateError: *value* is undefined itself.
    """
    if isinstance(value, Undefined):
        value.fail()
    try:
        if isinstance(value, dict):
            return value[key]
        if isinstance(value, (list, tuple, str, bytes)) and isinstance(key, int):
            return value[key]
        if isinstance(value, Namespace) and isinstance(key, str):
            return value.attributes[key]
        if isinstance(value, datetime) and isinstance(key, str) and key in _TIME_PARTS:
            return getattr(value, key)
    except (TypeError, LookupError):
        pass
    return UNDEFINED


def text(value: object) -> str:
    """Return the text of *value*, as Python has it.

    Raises:
        TemplateError: It is too long.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, (dict, list, tuple)):
        weigh(value)
    return str(value)


def weigh(value: object) -> int:
    """Return the number of values in *value*, itself counted, with one more for every 256 characters.

    Raises:
        TemplateError: There are more than a template may handle.
    """
    waiting = [value]
    count = characters = 0
    while waiting:
        item = waiting.pop()
        count += 1
        if isinstance(item, (str, bytes)):
            characters += len(item)
        elif isinstance(item, (dict, list, tuple)):
            if count + len(waiting) + len(item) > MAX_ITEMS:
                raise TemplateError(f"a list or mapping has more than {MAX_ITEMS} values")
            waiting.extend(item)
            if isinstance(item, dict):
                waiting.extend(item.values())
    if characters > MAX_TEXT:
        raise TemplateError(f"a text has more than {MAX_TEXT} characters")
    return count + characters // 256


def real(value: object) -> float:
    """Return ``float(value)``.

    Raises:
        TypeError: It is of another kind.
        ValueError: Its text is no number.
        TemplateError: It is undefined.
    """
    if isinstance(value, Undefined):
        value.fail()
    if not isinstance(value, (str, int, float)):
        raise TypeError(f"a {type(value).__name__} is no number")
    if isinstance(value, str) and len(value) > MAX_NUMERAL:
        raise ValueError(f"a text of {len(value)} characters is no number")
    return float(value)


def whole(value: object) -> int:
    """Return *value*, which must be a whole number.

    Raises:
        TypeError: It is none.
        TemplateError: It is undefined.
    """
    if isinstance(value, Undefined):
        value.fail()
    if not isinstance(value, int):
        raise TypeError(f"a {type(value).__name__} is not a whole number")
    return value
