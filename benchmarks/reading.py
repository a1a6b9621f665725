"""The message that the graph and its in-process peers carry."""

from __future__ import annotations

from homebot.messages import Message

__all__ = ["Reading", "make_reading"]


class Reading(Message):
    sensor: str
    celsius: float
    sequence: int


def make_reading(number: int) -> Reading:
    return Reading(sensor="kitchen", celsius=21.5, sequence=number)
