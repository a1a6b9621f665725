"""A template that needs Jinja's syntax."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import final

from homebot.gateways.mqtt.templates.errors import TemplateError

__all__ = ["Program"]


@final
class Program:
    """A template that needs Jinja's syntax; so far only one without any."""

    __slots__ = ("_text", "names")

    def __init__(self, text: str) -> None:
        self.names: frozenset[str] = frozenset()
        self._text = text

    @classmethod
    def parse(cls, source: str) -> Program:
        """Return the program that *source* is.

        Raises:
            TemplateError: It is none, or needs what is unsupported.
        """
        if "{{" in source or "{%" in source or "{#" in source:
            raise TemplateError("is more than a path into the message")
        return cls(source)

    def render(self, variables: Mapping[str, object], now: datetime | None) -> str:
        """Return its text with *variables*."""
        del variables, now
        return self._text
