"""Texts: methods of values, both ways of Python to format a text, filters, and regular expressions. Pure.

No width and no result is large; the work of regular expressions is counted.
"""

import base64
import binascii
import json
import re
import struct
from collections.abc import Callable, Iterable
from datetime import datetime, timedelta
from string import Formatter
from typing import Final

from homebot.conventions.bounded_patterns import PatternError, compile_bounded, compiling_work
from homebot.conventions.payload import parse_json
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.jinja.evaluation import Run
from homebot.integrations.homeassistant.formats.jinja.values import (
    MAX_ITEMS,
    MAX_TEXT,
    NotDefinedError,
    TemplateError,
    Undefined,
    text,
    whole,
)
from homebot.support.folding import fold


def percent(template: str, values: object) -> str:
    """Return ``template % values``; a width may have two digits."""
    if template.count("%") > _MAX_FIELDS or not _PERCENT.fullmatch(template):
        raise TemplateError("a text is formatted with more than plain values, or to a large width")
    return template % values


def _braces(template: str, values: tuple[object, ...], named: dict[str, object]) -> str:
    """Return ``template.format(*values, **named)``, with plain fields only."""
    if template.count("{") > _MAX_FIELDS:
        raise TemplateError(f"a text is formatted with more than {_MAX_FIELDS} values")
    for _, field, width, _ in Formatter().parse(template):
        if field is not None and not _FIELD.fullmatch(field):
            raise TemplateError("a text is formatted with more than plain values")
        if width and ("{" in width or _LARGE.search(width)):
            raise TemplateError("a text is formatted to a large width")
    return template.format(*values, **named)


def strftime_format(template: str) -> str:
    """Return *template*, a format of times; it must be short, with plain fields only."""
    if len(template) > _MAX_TIME_CHARACTERS or not _TIME.fullmatch(template):
        raise TemplateError("a time is formatted with more than plain fields")
    return template


_MAX_FIELDS = 32
_PERCENT = re.compile(r"(?:[^%]++|%(?:\([^()%]*+\))?[-+ #0]*+[0-9]{0,2}+(?:\.[0-9]{0,2}+)?[a-zA-Z%])*+")
_LARGE = re.compile(r"\d{3}")  # of any script, as for str.format
_FIELD = re.compile(r"[A-Za-z0-9_]{0,32}")
_MAX_TIME_CHARACTERS = 64
_TIME = re.compile(r"(?:[^%]|%-?[A-Za-z%])*")


def method_of(value: object, method: str) -> Callable[..., object]:
    """Return the method of that name of *value*; it takes the value first."""
    for kind, methods in METHODS.items():
        if isinstance(value, kind) and method in methods:
            return methods[method]
    raise TemplateError(f"a {type(value).__name__} has no method {method}()")


def replace(value: str, old: str, new: str, count: int = -1) -> str:
    """Return ``value.replace(old, new, count)`` of limited length."""
    times = value.count(old)
    if count >= 0:
        times = min(times, count)
    if len(value) + times * (len(new) - len(old)) > MAX_TEXT:
        raise TemplateError(f"a text has more than {MAX_TEXT} characters")
    return value.replace(old, new, count)


def join(separator: str, values: Iterable[str]) -> str:
    """Return ``separator.join(values)`` of limited length."""
    values = list(values)
    if len(separator) * len(values) + sum(map(len, values)) > MAX_TEXT:
        raise TemplateError(f"a text has more than {MAX_TEXT} characters")
    return separator.join(values)


def _splitting(split: Callable[..., list[str]]) -> Callable[..., list[str]]:
    def splitted(value: str, separator: str | None = None, maxsplit: int = -1) -> list[str]:
        return split(value, separator, MAX_ITEMS if maxsplit < 0 else min(maxsplit, MAX_ITEMS))

    return splitted


def _padding(pad: Callable[..., str]) -> Callable[..., str]:
    def padded(value: str, width: int, *fill: str) -> str:
        if width > MAX_TEXT:
            raise TemplateError(f"a text has more than {MAX_TEXT} characters")
        return pad(value, width, *fill)

    return padded


_TEXT_METHODS = (
    "capitalize count endswith find index isalnum isalpha isdecimal isdigit islower isnumeric isupper lower lstrip "
    "partition removeprefix removesuffix rfind rpartition rstrip splitlines startswith strip swapcase title upper"
)

METHODS: Final[dict[type, dict[str, Callable[..., object]]]] = {
    str: {
        **{name: getattr(str, name) for name in _TEXT_METHODS.split()},
        **{name: _padding(getattr(str, name)) for name in ("center", "ljust", "rjust", "zfill")},
        **{name: _splitting(getattr(str, name)) for name in ("split", "rsplit")},
        "format": lambda value, *values, **named: _braces(value, values, named),
        "join": join,
        "replace": replace,
    },
    dict: {
        "get": dict.get,
        "items": lambda value: list(value.items()),
        "keys": list,
        "values": lambda value: list(value.values()),
    },
    list: {"count": list.count, "index": list.index},
    tuple: {"count": tuple.count, "index": tuple.index},
    float: {"is_integer": float.is_integer},
    datetime: {
        "isoformat": datetime.isoformat,
        "isoweekday": datetime.isoweekday,
        "strftime": lambda value, template: value.strftime(strftime_format(template)),
        "timestamp": datetime.timestamp,
        "weekday": datetime.weekday,
    },
    timedelta: {"total_seconds": timedelta.total_seconds},
}
"""By the type of the value, by name."""


def _default(_: Run, value: object, default: object = "", boolean: object = False) -> object:
    return default if isinstance(value, Undefined) or (boolean and not value) else value


def _is_defined(_: Run, value: object) -> object:
    if isinstance(value, Undefined):
        raise NotDefinedError("the message lacks the value that the template uses")
    return value


def _title(run: Run, value: object) -> str:
    run.spend(len(text(value)) // 4)
    return "".join(word[0].upper() + word[1:].lower() for word in _WORD_STARTS.split(text(value)) if word)


def _replace(_: Run, value: object, old: object, new: object, count: object = None) -> str:
    return replace(text(value), text(old), text(new), -1 if count is None else whole(count))


def _trim(_: Run, value: object, characters: object = None) -> str:
    return text(value).strip(None if characters is None else text(characters))


def _truncate(
    _: Run, value: object, length: object = 255, killwords: object = False, end: object = "...", leeway: object = 5
) -> object:
    if not isinstance(value, (str, list, tuple, dict, Undefined)):
        raise TypeError(f"truncate is given a {type(value).__name__}")
    ending, longest, extra = text(end), whole(length), 5 if leeway is None else whole(leeway)
    if longest < len(ending) or extra < 0:
        raise TemplateError("truncate is given a length below that of its end")
    if len(value) <= longest + extra:
        return value
    if not isinstance(value, str):
        raise TypeError(f"truncate is given a long {type(value).__name__}")
    kept = value[: longest - len(ending)]
    return (kept if killwords else kept.rsplit(" ", 1)[0]) + ending


def _format(_: Run, value: object, *values: object, **named: object) -> str:
    if values and named:
        raise TypeError("format takes values or names")
    return percent(text(value), named or values)


def _from_json(_: Run, value: object) -> object:
    try:
        return parse_json(text(value), lenient=True)
    except WireError:
        raise TemplateError("from_json is given text that is not JSON") from None


def _to_json(
    _: Run, value: object, ensure_ascii: object = False, pretty_print: object = False, sort_keys: object = False
) -> str:
    pretty = bool(pretty_print)
    return json.dumps(
        value,
        ensure_ascii=bool(ensure_ascii),
        indent=2 if pretty else None,
        sort_keys=bool(sort_keys),
        separators=None if ensure_ascii or pretty else (",", ":"),
    )


def _jinja_json(_: Run, value: object, indent: object = None) -> str:
    spaces = None if indent is None else whole(indent)
    if spaces is not None and not 0 <= spaces <= _WIDEST_INDENT:
        raise TemplateError("JSON is indented too far")
    return json.dumps(value, sort_keys=True, indent=spaces).translate(_HTML)


def _base64_encode(_: Run, value: object) -> str:
    return base64.b64encode(value if isinstance(value, bytes) else text(value).encode()).decode()


def _base64_decode(_: Run, value: object, encoding: object = "utf-8") -> object:
    try:
        decoded = base64.b64decode(text(value))
    except binascii.Error as error:
        raise TemplateError("base64_decode is given text that is not Base64") from error
    if not encoding:
        return decoded
    if text(encoding).lower() not in _ENCODINGS:
        raise TemplateError("base64_decode is given an encoding that is not supported")
    return decoded.decode(text(encoding))


def _pack(_: Run, value: object, layout: object) -> object:
    try:
        return struct.pack(_layout(layout), value)
    except struct.error:
        return None


def _unpack(_: Run, value: object, layout: object, offset: object = 0) -> object:
    if not isinstance(value, bytes):
        raise TypeError(f"unpack is given a {type(value).__name__}")
    try:
        return struct.unpack_from(_layout(layout), value, whole(offset))[0]
    except struct.error:
        return None


def _layout(layout: object) -> str:
    shape = text(layout)
    if not _LAYOUT.fullmatch(shape):
        raise TemplateError("bytes are packed in more than single values")
    return shape


def _slugify(run: Run, value: object, separator: object = "_") -> str:
    """Return the words of a text in small Latin letters; ``unknown`` if it has other ones alone."""
    source = text(value)
    run.spend(len(source) // 4)
    slug = text(separator)[:_MAX_FIELDS].join(filter(None, _NO_SLUG.split(fold(source))))
    return slug or ("unknown" if source else "")


_NO_SLUG = re.compile("[^0-9a-z]+")


def _of_text(make: Callable[[str], str]) -> Callable[..., object]:
    return lambda _, value: make(text(value))


_WORD_STARTS = re.compile(r"([-\s({\[<]+)")
_HTML = {ord(sign): f"\\u{ord(sign):04x}" for sign in "<>&'"}
_WIDEST_INDENT = 8
_ENCODINGS = frozenset({"utf-8", "utf8", "ascii", "latin-1", "iso-8859-1"})
_LAYOUT = re.compile("[@=<>!]?[a-zA-Z?]{1,16}")

TEXT_FUNCTIONS: Final[dict[str, Callable[..., object]]] = {"pack": _pack, "slugify": _slugify, "unpack": _unpack}
"""By name; each takes the run first."""

TEXT_FILTERS: Final[dict[str, Callable[..., object]]] = {
    **TEXT_FUNCTIONS,
    "base64_decode": _base64_decode,
    "base64_encode": _base64_encode,
    "capitalize": _of_text(str.capitalize),
    "center": lambda _, value, width=80: METHODS[str]["center"](text(value), whole(width)),
    "d": _default,
    "default": _default,
    "format": _format,
    "from_json": _from_json,
    "is_defined": _is_defined,
    "lower": _of_text(str.lower),
    "ord": lambda _, value: ord(text(value)),
    "replace": _replace,
    "string": _of_text(str),
    "title": _title,
    "to_json": _to_json,
    "tojson": _jinja_json,
    "trim": _trim,
    "truncate": _truncate,
    "upper": _of_text(str.upper),
}
"""By name; each takes the run and the value first."""


def matches(run: Run, value: object, find: object = "", ignorecase: object = False) -> bool:
    """Return whether *value* begins with a match of *find*."""
    subject = text(value)
    return _pattern(run, find, subject, ignorecase).match(subject) is not None


def searches(run: Run, value: object, find: object = "", ignorecase: object = False) -> bool:
    """Return whether *value* has a match of *find* somewhere."""
    subject = text(value)
    return _pattern(run, find, subject, ignorecase).search(subject) is not None


def replaces(run: Run, value: object = "", find: object = "", replace: object = "", ignorecase: object = False) -> str:
    """Return *value* with every match of *find* replaced."""
    subject, replacement = text(value), text(replace)
    pattern = _pattern(run, find, subject, ignorecase)
    # Matches lie side by side, so that all that one reference gives is no longer than the value.
    longest = (len(subject) + 1) * (len(replacement) + 1) + replacement.count("\\") * len(subject)
    if longest > MAX_TEXT:
        raise TemplateError(f"a text has more than {MAX_TEXT} characters")
    try:
        return pattern.sub(replacement, subject)
    except re.error as error:
        raise TemplateError("a regular expression has a wrong replacement") from error


def find_all(run: Run, value: object, find: object = "", ignorecase: object = False) -> list[object]:
    """Return every match of *find* in *value*; its groups where it has any."""
    subject = text(value)
    return _pattern(run, find, subject, ignorecase).findall(subject)


def find_all_index(run: Run, value: object, find: object = "", index: object = 0, ignorecase: object = False) -> object:
    """Return one of the matches that :func:`find_all` gives."""
    return find_all(run, value, find, ignorecase)[whole(index)]


def _pattern(run: Run, find: object, subject: str, ignorecase: object) -> re.Pattern[str]:
    expression = text(find)
    try:
        run.spend(compiling_work(expression))
        bounded = compile_bounded(expression, re.IGNORECASE if ignorecase else re.NOFLAG)
    except PatternError as error:
        raise TemplateError(str(error)) from error
    run.spend(bounded.work(subject))
    return bounded.pattern
