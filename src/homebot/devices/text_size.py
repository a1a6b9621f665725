"""Memory of the texts of a device: all that a stranger can make long. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.devices.part import Part

__all__ = ["size_of_parts", "size_of_texts"]

_EACH = 32
"""Bytes that a text takes beside its characters, about."""


def size_of_texts(texts: Iterable[str]) -> int:
    """Return the size of *texts* in bytes, about."""
    lengths = [*map(len, texts)]
    return sum(lengths) + _EACH * len(lengths)


def size_of_parts(parts: Iterable[Part]) -> int:
    """Return the size of the topics and options of *parts* in bytes, about; the rest of a part is short."""
    size = 0
    for part in parts:
        size += sum(map(len, part.reads)) + sum(map(len, part.writes)) + _EACH * (len(part.reads) + len(part.writes))
        for capability in part.capabilities:
            if capability.options:
                size += size_of_texts(capability.options)
    return size
