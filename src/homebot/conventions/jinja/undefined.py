"""The value of what is not there, as Jinja has it: an empty text that nothing can be done with."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NoReturn

from homebot.conventions.jinja.errors import UndefinedValueError

__all__ = ["UNDEFINED", "Undefined"]


class Undefined:
    """The value of a name, a key or an index that has none.

    It is false, empty and equal to its like, and its text is empty. Arithmetic, order, and looking into it raise
    :class:`UndefinedValueError`.

    Source: Jinja 3.1 documentation, Undefined Types, ``Undefined``.
    """

    __slots__ = ()

    def __str__(self) -> str:
        return ""

    def __repr__(self) -> str:
        return "Undefined"

    def __bool__(self) -> bool:
        return False

    def __len__(self) -> int:
        return 0

    def __iter__(self) -> Iterator[object]:
        return iter(())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Undefined)

    def __hash__(self) -> int:
        return id(Undefined)

    def fail(self, *_: object) -> NoReturn:
        """Raise what every use of the value raises."""
        raise UndefinedValueError("a value that the template uses is not in the message")

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = fail
    __floordiv__ = __rfloordiv__ = __mod__ = __rmod__ = __pow__ = __rpow__ = __neg__ = __pos__ = fail
    __getitem__ = __lt__ = __le__ = __gt__ = __ge__ = __int__ = __float__ = fail


UNDEFINED = Undefined()
