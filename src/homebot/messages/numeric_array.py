"""Numeric arrays in messages, stored as machine numbers: an eighth of a tuple's memory, without an object each."""

import sys
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar, overload

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

LAYOUTS: Final = {
    "byte": "B",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
"""The type code in the modules ``array`` and ``struct`` for each numeric primitive of ROS."""

NumberT = TypeVar("NumberT", int, float)


class NumericArray(Sequence[NumberT]):
    """An immutable sequence of numbers of one size, with the equality and hash of a tuple of the same numbers.

    Numbers of ``float32`` keep their original precision until they are written in CDR.
    """

    __slots__ = ("_values",)

    def __init__(self, layout: str, values: Iterable[Any] = ()) -> None:
        self._values = array(layout, values)

    def __len__(self) -> int:
        return len(self._values)

    @overload
    def __getitem__(self, index: int) -> NumberT: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[NumberT, ...]: ...
    def __getitem__(self, index: int | slice) -> NumberT | tuple[NumberT, ...]:
        value: Any = self._values[index]
        return tuple(value) if isinstance(index, slice) else value

    def __iter__(self) -> Iterator[NumberT]:
        return iter(self._values)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, NumericArray):
            return self._values == other._values
        return tuple(self._values) == other if isinstance(other, tuple) else NotImplemented

    def __hash__(self) -> int:
        return hash(tuple(self._values))

    def __repr__(self) -> str:
        return repr(tuple(self._values))

    @property
    def buffer(self) -> memoryview:
        """The numbers as a read-only buffer in native byte order, for ``numpy.frombuffer``."""
        return memoryview(self._values).toreadonly()

    def tolist(self) -> list[NumberT]:
        """Return the numbers as a list."""
        return self._values.tolist()

    def to_bytes(self, layout: str) -> bytes:
        """Return the numbers in *layout*, little-endian; one too large for ``float32`` becomes infinite."""
        values = self._values if layout == self._values.typecode else array(layout, self._values)
        return _little_endian(values).tobytes()


@dataclass(frozen=True, slots=True)
class RosArray:
    """Marks a sequence of numbers with the ROS primitive of its elements; read by pydantic.

    A value may be a list, a tuple, an ``array``, or little-endian bytes of such numbers. Booleans count as 0 and 1, as
    in ROS.

    Attributes:
        name: The primitive, for example ``int8``.
        element: The annotated Python type of an element, to find the invalid ones.
    """

    name: str
    element: Any

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema that converts all numbers at once, and finds an invalid one if there is any."""
        number = handler.generate_schema(self.element)
        plain = core_schema.float_schema() if self.name.startswith("float") else core_schema.int_schema()
        return core_schema.no_info_wrap_validator_function(
            self._convert,
            core_schema.tuple_variable_schema(number),
            serialization=core_schema.plain_serializer_function_ser_schema(
                _plain, return_schema=core_schema.list_schema(plain)
            ),
        )

    def _convert(self, value: object, check: Callable[[object], object]) -> NumericArray[Any]:
        held = "d" if self.name == "float32" else LAYOUTS[self.name]
        if isinstance(value, NumericArray) and value.buffer.format == held:
            return value
        if isinstance(value, bytes | bytearray | memoryview):
            return NumericArray(held, self._of_bytes(bytes(value)))
        if isinstance(value, list | tuple | array | NumericArray):
            try:
                return NumericArray(held, value)
            except (TypeError, OverflowError):
                value = tuple(value)
        checked: Any = check(value)
        return NumericArray(held, checked)

    def _of_bytes(self, value: bytes) -> "array[Any]":
        numbers: array[Any] = array(LAYOUTS[self.name])
        if len(value) % numbers.itemsize:
            raise PydanticCustomError(
                "bytes_size",
                "{size} bytes are not a whole number of {name}, which has {each}",
                {"size": len(value), "name": self.name, "each": numbers.itemsize},
            )
        numbers.frombytes(value)
        return _little_endian(numbers)


def _plain(value: Sequence[Any]) -> list[Any]:
    """Return *value* as a list; in an unvalidated message it is another sequence."""
    return value.tolist() if isinstance(value, NumericArray) else list(value)


def _little_endian(numbers: "array[Any]") -> "array[Any]":
    """Return *numbers* with swapped bytes if this machine is big-endian."""
    if sys.byteorder == "big":
        numbers = numbers[:]
        numbers.byteswap()
    return numbers
