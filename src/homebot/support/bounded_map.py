"""A bounded map: the newest entries by key. Pure."""

from collections import OrderedDict
from typing import TypeVar, final

__all__ = ["BoundedMap"]

Key = TypeVar("Key")
Value = TypeVar("Value")


@final
class BoundedMap(OrderedDict[Key, Value]):
    """A dictionary that drops its oldest entry when too large; assignment makes an entry the newest."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def __setitem__(self, key: Key, value: Value) -> None:
        super().__setitem__(key, value)
        self.move_to_end(key)
        if len(self) > self._most:
            self.popitem(last=False)
