"""Tests, the words after ``is``, and filters over lists and mappings. Pure."""

import re
from collections.abc import Callable, Sequence
from datetime import datetime
from typing import Final

from homebot.integrations.homeassistant.formats.jinja.evaluation import Run
from homebot.integrations.homeassistant.formats.jinja.numbers import BINARY, ORDER, is_number
from homebot.integrations.homeassistant.formats.jinja.texts import join, matches, searches
from homebot.integrations.homeassistant.formats.jinja.values import (
    MAX_ITEMS,
    UNDEFINED,
    TemplateError,
    Undefined,
    item,
    text,
    whole,
)


def _order(operator: str) -> Callable[..., object]:
    compare = ORDER[operator]
    return lambda _, value, other: compare(value, other)


def _of_kind(*kinds: type) -> Callable[..., object]:
    return lambda _, value: isinstance(value, kinds)


def _remains(remainder: int) -> Callable[..., object]:
    return lambda _, value: BINARY["Mod"](value, 2) == remainder


_ORDERS: Final = {
    "eq": ("==", "eq", "equalto"),
    "ne": ("!=", "ne"),
    "lt": ("<", "lt", "lessthan"),
    "lteq": ("<=", "le"),
    "gt": (">", "gt", "greaterthan"),
    "gteq": (">=", "ge"),
    "in": ("in",),
}
"""Names of each comparison."""

CHECKS: Final[dict[str, Callable[..., object]]] = {
    **{name: _order(operator) for operator, names in _ORDERS.items() for name in names},
    "boolean": _of_kind(bool),
    "contains": lambda _, value, item: ORDER["in"](item, value),
    "datetime": _of_kind(datetime),
    "defined": lambda _, value: not isinstance(value, Undefined),
    "divisibleby": lambda _, value, by: BINARY["Mod"](value, by) == 0,
    "even": _remains(0),
    "false": lambda _, value: value is False,
    "float": _of_kind(float),
    "integer": lambda _, value: isinstance(value, int) and not isinstance(value, bool),
    "is_number": is_number,
    "iterable": _of_kind(str, bytes, list, tuple, dict, Undefined),
    "list": _of_kind(list),
    "lower": lambda _, value: text(value).islower(),
    "mapping": _of_kind(dict),
    "match": matches,
    "none": lambda _, value: value is None,
    "number": _of_kind(int, float),
    "odd": _remains(1),
    "sameas": lambda _, value, other: value is other,
    "search": searches,
    "sequence": _of_kind(str, bytes, list, tuple, dict, Undefined),
    "string": _of_kind(str),
    "string_like": _of_kind(str, bytes),
    "true": lambda _, value: value is True,
    "tuple": _of_kind(tuple),
    "undefined": _of_kind(Undefined),
    "upper": lambda _, value: text(value).isupper(),
}
"""By name; each takes the run and the value first."""


def slice_of(many: object, bounds: Sequence[object]) -> object:
    """Return a slice of a list or text."""
    if isinstance(many, Undefined):
        many.fail()
    if not isinstance(many, (str, bytes, list, tuple)):
        raise TypeError(f"a {type(many).__name__} cannot be indexed")
    start, stop, step = (None if bound is None else whole(bound) for bound in bounds)
    return many[start:stop:step]


def values_of(run: Run, value: object) -> list[object]:
    """Return the values of iterating *value*: the items of a list, the keys of a mapping, the characters of a text.

    Raises:
        TemplateError: There are too many.
        TypeError: There is nothing to go through.
    """
    if isinstance(value, Undefined):
        return []
    if not isinstance(value, (list, tuple, dict, str)):
        raise TypeError(f"a {type(value).__name__} has no items")
    if len(value) > MAX_ITEMS:
        raise TemplateError(f"a list or mapping has more than {MAX_ITEMS} values")
    run.spend(1 + len(value) // 16)
    return list(value)


def attribute_of(value: object, path: object) -> object:
    """Return the value at *path* in *value*: keys and indexes with dots between them, or one index."""
    parts: list[object] = [*path.split(".", _DEEPEST)] if isinstance(path, str) else [path]
    if len(parts) > _DEEPEST:
        raise TemplateError(f"an attribute is more than {_DEEPEST} levels deep")
    for part in parts:
        value = item(value, int(part) if isinstance(part, str) and _INDEX.fullmatch(part) else part)
    return value


def _key(case_sensitive: object, attribute: object) -> Callable[[object], object]:
    def key(value: object) -> object:
        key = value if attribute is None else attribute_of(value, attribute)
        return key.lower() if isinstance(key, str) and not case_sensitive else key

    return key


def _sort(
    run: Run, value: object, reverse: object = False, case_sensitive: object = False, attribute: object = None
) -> object:
    values = values_of(run, value)
    run.spend(len(values))
    key: Callable[..., object] = _key(case_sensitive, attribute)
    return _python_sorted(values, key=key, reverse=bool(reverse))


def _extreme(choose: Callable[..., object]) -> Callable[..., object]:
    def extreme(run: Run, value: object, case_sensitive: object = False, attribute: object = None) -> object:
        values = values_of(run, value)
        run.spend(len(values))
        return choose(values, key=_key(case_sensitive, attribute)) if values else UNDEFINED

    return extreme


_MIN, _MAX = _extreme(min), _extreme(max)


def _of_arguments(extreme: Callable[..., object]) -> Callable[..., object]:
    return lambda run, *values, **named: extreme(run, values[0] if len(values) == 1 else values, **named)


def _unique(run: Run, value: object, case_sensitive: object = False, attribute: object = None) -> object:
    values = values_of(run, value)
    run.spend(len(values))
    key = _key(case_sensitive, attribute)
    first: dict[object, object] = {}
    for element in values:
        first.setdefault(key(element), element)
    return list(first.values())


def _sum(run: Run, value: object, attribute: object = None, start: object = 0) -> object:
    total: int | float = 0
    for addend in [start, *values_of(run, value)]:
        number = addend if attribute is None or addend is start else attribute_of(addend, attribute)
        if isinstance(number, Undefined):
            number.fail()
        if not isinstance(number, (int, float)):
            raise TypeError(f"a {type(number).__name__} cannot be summed")
        total += number
    return total


def _selecting(*, expected: bool, of_attribute: bool) -> Callable[..., object]:
    def select(run: Run, value: object, *arguments: object) -> object:
        values = values_of(run, value) if value else []
        run.spend(4 * len(values))
        rest = arguments[1:] if of_attribute else arguments
        check = CHECKS[str(rest[0])] if rest else lambda _, element: bool(element)
        chosen: list[object] = []
        for element in values:
            checked = attribute_of(element, arguments[0]) if of_attribute else element
            run.spend_on_search((checked, *rest[1:]))
            if bool(check(run, checked, *rest[1:])) is expected:
                chosen.append(element)
        return chosen

    return select


def _join(run: Run, value: object, separator: object = "", attribute: object = None) -> str:
    values = values_of(run, value)
    items = values if attribute is None else [attribute_of(value, attribute) for value in values]
    return join(text(separator), [text(run.handle(item)) for item in items])


def _end(index: int) -> Callable[..., object]:
    def end(run: Run, value: object) -> object:
        values = value if isinstance(value, str) else values_of(run, value)
        return values[index] if values else UNDEFINED

    return end


def _length(_: Run, value: object) -> int:
    if isinstance(value, (str, bytes, list, tuple, dict, Undefined)):
        return len(value)
    raise TypeError(f"a {type(value).__name__} has no length")


def _items(_: Run, value: object) -> object:
    if isinstance(value, Undefined):
        return []
    if not isinstance(value, dict):
        raise TypeError("only a mapping has items")
    return list(value.items())


def _dictionary_sort(
    run: Run, value: object, case_sensitive: object = False, by: object = "key", reverse: object = False
) -> object:
    if not isinstance(value, dict):
        raise TypeError("only a mapping can be sorted by its keys")
    column = {"key": 0, "value": 1}[str(by)]
    return _sort(run, _items(run, value), reverse, case_sensitive, column)


def _range(_: Run, *bounds: object) -> object:
    numbers = range(*[whole(bound) for bound in bounds])
    if len(numbers) > MAX_ITEMS:
        raise TemplateError(f"a range has more than {MAX_ITEMS} numbers")
    return list(numbers)


def _of(kind: Callable[[list[object]], object]) -> Callable[..., object]:
    return lambda run, value: kind(values_of(run, value))


def _dictionary(run: Run, *values: object, **named: object) -> object:
    """Return a mapping of another mapping or of pairs, and of *named* values."""
    return _python_dict(*[value if isinstance(value, dict) else values_of(run, value) for value in values], **named)


def _attribute(_: Run, value: object, name: object) -> object:
    return UNDEFINED if isinstance(value, dict) else item(value, name)  # a key of a mapping is none


def _combine(run: Run, *values: object, recursive: object = False) -> dict[object, object]:
    """Return a mapping with the items of *values*, of which later ones count; nested mappings too if *recursive*."""
    by_key: dict[object, object] = {}
    for mapping in values:
        if not isinstance(mapping, dict):
            raise TypeError(f"combine is given a {type(mapping).__name__}")
        run.spend(1 + len(mapping))
        for key, value in mapping.items():
            is_nested = recursive and isinstance(value, dict) and isinstance(by_key.get(key), dict)
            by_key[key] = _combine(run, by_key[key], value, recursive=True) if is_nested else value
    return by_key


_DEEPEST = 8
_INDEX = re.compile("[0-9]{1,5}", re.ASCII)
_python_sorted: Callable[..., object] = sorted
_python_dict: Callable[..., object] = dict

LIST_FILTERS: Final[dict[str, Callable[..., object]]] = {
    "attr": _attribute,
    "combine": _combine,
    "count": _length,
    "dictsort": _dictionary_sort,
    "first": _end(0),
    "items": _items,
    "join": _join,
    "last": _end(-1),
    "length": _length,
    "list": _of(list),
    "max": _MAX,
    "min": _MIN,
    "reject": _selecting(expected=False, of_attribute=False),
    "rejectattr": _selecting(expected=False, of_attribute=True),
    "reverse": lambda run, value: value[::-1] if isinstance(value, str) else values_of(run, value)[::-1],
    "select": _selecting(expected=True, of_attribute=False),
    "selectattr": _selecting(expected=True, of_attribute=True),
    "sort": _sort,
    "sum": _sum,
    "unique": _unique,
}
"""By name; each takes the run and the value first."""

LIST_FUNCTIONS: Final[dict[str, Callable[..., object]]] = {
    "combine": _combine,
    "dict": _dictionary,
    "max": _of_arguments(_MAX),
    "min": _of_arguments(_MIN),
    "range": _range,
    "tuple": _of(tuple),
    "zip": lambda run, *lists: list(zip(*[values_of(run, listed) for listed in lists], strict=False)),
}
"""By name; each takes the run first."""
