"""Frames read at once."""

from collections.abc import Generator
from typing import TypeVar

from homebot.bridges.rosbridge import protocol
from homebot.bridges.rosbridge.protocol import Operation

T = TypeVar("T")


def result_of(steps: Generator[None, None, T]) -> T:
    """Return what *steps* return."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            found: T = end.value
            return found


def parse_frame(text: str) -> Operation:
    """Return the operation that *text* asks for."""
    return result_of(protocol.parse_frame(text))
