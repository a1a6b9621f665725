"""A bounded map: the newest entries by key. Pure."""

from collections import OrderedDict
from collections.abc import Callable
from typing import TypeVar

Key = TypeVar("Key")
Value = TypeVar("Value")


class BoundedMap(OrderedDict[Key, Value]):
    """A dictionary that drops its oldest entry when too large; assignment makes an entry the newest.

    Args:
        on_drop: Called with each dropped key and value.
    """

    def __init__(self, most: int, on_drop: Callable[[Key, Value], object] = lambda *_: None) -> None:
        super().__init__()
        self._most = most
        self._on_drop = on_drop

    def __setitem__(self, key: Key, value: Value) -> None:
        super().__setitem__(key, value)
        self.move_to_end(key)
        if len(self) > self._most:
            self._on_drop(*self.popitem(last=False))
