"""Limits on the work of a stranger's template, and the errors that name its mistakes. Pure."""

from __future__ import annotations

from typing import Final

from homebot.errors import WireError

__all__ = [
    "MAX_DEPTH",
    "MAX_FOR_DEPTH",
    "MAX_ITEMS",
    "MAX_NUMBER_BITS",
    "MAX_NUMERAL",
    "MAX_SOURCE",
    "MAX_STEPS",
    "MAX_TEXT",
    "MAX_TOKENS",
    "NotDefinedError",
    "TemplateError",
    "UndefinedValueError",
]


class TemplateError(WireError):
    """A template gives no text: it is unsupported, or fails with these values, or would do too much work."""


class UndefinedValueError(TemplateError):
    """A template does something with a value that is not there; Jinja's ``UndefinedError``."""


class NotDefinedError(UndefinedValueError):
    """A message lacks a value that the template checks by ``is_defined``: it is for another reader, and no fault."""


MAX_SOURCE: Final = 8192
"""Longest source, in characters."""

MAX_TOKENS: Final = 1024
"""Most words, signs and spaces of code in a source. Jinja's parser needs about 15 microseconds for each."""

MAX_DEPTH: Final = 64
"""Deepest nesting of brackets in a source, and of one operation in another; far from Python's recursion limit."""

MAX_FOR_DEPTH: Final = 4
"""Deepest nesting of loops."""

MAX_STEPS: Final = 10_000
"""Most work of one rendering. A step is about a microsecond: one operation, four values of a list, or
256 characters."""

MAX_TEXT: Final = 65_536
"""Longest text, also the rendered one, in characters."""

MAX_ITEMS: Final = 4096
"""Most values in a list or mapping, with those in its items."""

MAX_NUMBER_BITS: Final = 256
"""Largest whole number that can be calculated with, in bits."""

MAX_NUMERAL: Final = 400
"""Longest text that is read as a number, in characters: any finite float has fewer digits."""
