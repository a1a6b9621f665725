"""Values of apps that survive restarts: JSON by key, ``self.store["armed"] = True``.

Values are in memory, so that reading and writing never wait; the file is written within five seconds, and when the app
ends. Values are copied when stored. A list or dict that is read is the stored one: ``self.store["log"].append(1)``.
"""

import json
from collections.abc import Callable, Iterator, MutableMapping
from typing import Any, Final, final

from homebot.errors import UsageError

MAX_VALUE_BYTES: Final = 65_536
"""The limit of bytes of a value, as JSON."""

MAX_KEYS: Final = 1000
"""The limit of keys of an app."""

MAX_BYTES: Final = 1_048_576
"""The limit of bytes of all values of an app."""

_MAX_KEY: Final = 200


def _storing(kind: Any, *names: str) -> Any:
    """Return a subclass of list or dict whose methods *names* change it, and then call its ``save``."""

    def storing(name: str) -> Callable[..., object]:
        change = getattr(kind, name)

        def method(self: Any, *args: object, **named: object) -> object:
            result = change(self, *args, **named)
            for key, value in tuple(self.items() if kind is dict else enumerate(self)):
                if type(value) in (list, tuple, dict):
                    kind.__setitem__(self, key, _wrap_stored(value, self.save))
            self.save()
            return self[args[0]] if name == "setdefault" else result

        return method

    return type(kind.__name__, (kind,), {name: storing(name) for name in names})


_List = _storing(
    list,
    *("append", "extend", "insert", "remove", "pop", "clear", "sort", "reverse"),
    *("__setitem__", "__delitem__", "__iadd__", "__imul__"),
)
_Dict = _storing(dict, "__setitem__", "__delitem__", "__ior__", "update", "setdefault", "pop", "popitem", "clear")


def _wrap_stored(value: Any, save: Callable[[], None]) -> Any:
    """Return a copy of a JSON value that calls *save* after each change of a list or dict in it."""
    if isinstance(value, list | tuple):
        container = _List(_wrap_stored(item, save) for item in value)
    elif isinstance(value, dict):
        container = _Dict({key: _wrap_stored(item, save) for key, item in value.items()})
    else:
        return value
    container.save = save
    return container


@final
class Store(MutableMapping[str, Any]):  # any JSON value
    """The stored values of one app. Keys that begin with ``_`` are reserved for homebot and not listed.

    Args:
        texts: The JSON text of each key; updated in place.
        on_change: Called with each key that changes.
    """

    def __init__(
        self, app: str, texts: dict[str, str] | None = None, on_change: Callable[[str], None] = lambda _: None
    ) -> None:
        self._app = app
        self._texts = {} if texts is None else texts
        self._on_change = on_change
        self._read: dict[str, Any] = {}  # the lists and dicts that were read
        self._bytes = sum(map(len, self._texts.values()))

    def __getitem__(self, key: str) -> Any:  # as above
        """Return the value of *key*; a list or dict is stored after each change.

        Raises:
            KeyError: There is no such key.
        """
        if key in self._read:
            return self._read[key]

        def save() -> None:
            if self._read.get(key) is value:  # otherwise another one was stored meanwhile
                self[key] = value

        value = _wrap_stored(json.loads(self._texts[key]), save)
        if isinstance(value, list | dict):
            self._read[key] = value
        return value

    def __setitem__(self, key: str, value: Any) -> None:  # as above
        """Store a copy of *value* under *key*.

        Raises:
            UsageError: It is not a JSON value, or too large; or the key is invalid, or one too many.
        """
        read = self._read.pop(key, None)  # if it cannot be stored, the old value counts
        text = self._check(key, value)
        if read is not None and read is value:
            self._read[key] = read
        before = self._texts.get(key)
        if text != before:
            self._bytes += len(text) - len(before or "")
            self._texts[key] = text
            self._on_change(key)

    def setdefault(self, key: str, default: Any = None) -> Any:  # as above
        """Return the value of *key*, after storing *default* if there is none."""
        if key not in self:
            self[key] = default
        return self[key]

    def __delitem__(self, key: str) -> None:
        """Remove *key*.

        Raises:
            KeyError: There is no such key.
        """
        self._read.pop(key, None)
        self._bytes -= len(self._texts.pop(key))
        self._on_change(key)

    def __iter__(self) -> Iterator[str]:
        """Return the keys in the order in which they were first stored."""
        return (key for key in tuple(self._texts) if not key.startswith("_"))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __repr__(self) -> str:
        return f"<store of {self._app}: {', '.join(self) or 'empty'}>"

    def _check(self, key: object, value: object) -> str:
        if not isinstance(key, str) or not 0 < len(key) <= _MAX_KEY or not key.isprintable():
            raise UsageError(
                f"{self._app}: a key of the store is a printable text of 1 to {_MAX_KEY} characters, got {key!r:.60}"
            )
        place = f"{self._app}: store[{key!r:.60}]"
        try:
            text = json.dumps(value, allow_nan=False, separators=(",", ":"))
        except (TypeError, ValueError, RecursionError) as exc:
            raise UsageError(
                f"{place} takes text, numbers, booleans, None, and lists and dicts of these, got {value!r:.60}: {exc}"
            ) from exc
        others = self._bytes - len(self._texts.get(key, ""))
        if len(text) > MAX_VALUE_BYTES:
            problem = f"a value takes at most {MAX_VALUE_BYTES:,} bytes as JSON, got {len(text):,}"
        elif others + len(text) > MAX_BYTES:
            problem = f"the values of an app take at most {MAX_BYTES:,} bytes, and the others take {others:,}"
        elif key not in self._texts and len(self._texts) >= MAX_KEYS:
            problem = f"an app has at most {MAX_KEYS:,} keys; remove some first"
        else:
            return text
        raise UsageError(f"{place}: {problem}")
