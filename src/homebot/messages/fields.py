"""Field types that say exactly which ROS type they are, and hold whole numbers to its range.

Plain ``bool``, ``int``, ``float``, ``str`` and ``bytes`` mean ``bool``, ``int64``, ``float64``, ``string`` and
``uint8[]``; the names here are the others. ``tuple[T, ...]`` is ``T[]``, bounded by ``Field(max_length=n)``
(``T[<=n]``), of fixed length when ``min_length`` is the same number (``T[n]``).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

__all__ = [
    "Float32",
    "Float64",
    "Int8",
    "Int16",
    "Int32",
    "Int64",
    "RosType",
    "UInt8",
    "UInt16",
    "UInt32",
    "UInt64",
]


@dataclass(frozen=True, slots=True)
class RosType:
    """Marks an annotated Python type with the ROS primitive it stands for.

    Attributes:
        name: The primitive's name in a ``.msg`` file, for example ``uint8``.
    """

    name: str


Int8 = Annotated[int, RosType("int8"), Field(ge=-(2**7), lt=2**7)]
Int16 = Annotated[int, RosType("int16"), Field(ge=-(2**15), lt=2**15)]
Int32 = Annotated[int, RosType("int32"), Field(ge=-(2**31), lt=2**31)]
Int64 = Annotated[int, RosType("int64"), Field(ge=-(2**63), lt=2**63)]
UInt8 = Annotated[int, RosType("uint8"), Field(ge=0, lt=2**8)]
UInt16 = Annotated[int, RosType("uint16"), Field(ge=0, lt=2**16)]
UInt32 = Annotated[int, RosType("uint32"), Field(ge=0, lt=2**32)]
UInt64 = Annotated[int, RosType("uint64"), Field(ge=0, lt=2**64)]
Float32 = Annotated[float, RosType("float32")]
Float64 = Annotated[float, RosType("float64")]
