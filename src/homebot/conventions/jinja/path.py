r"""The form that nine of ten templates have, ``{{ value_json.a["b"] }}``, without Jinja."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import final

from homebot.conventions.jinja.errors import NotDefinedError
from homebot.conventions.jinja.payload_context import PayloadContext
from homebot.conventions.jinja.undefined import UNDEFINED
from homebot.conventions.jinja.values import item, text

__all__ = ["Path"]


@final
class Path:
    """A template that is nothing but a variable, or a path into one: ``value`` or ``value_json``.

    Args:
        name: The variable.
        keys: The path.
        must_be: Whether the template ends in ``| is_defined``.
    """

    __slots__ = ("_keys", "_must_be", "name")

    def __init__(self, name: str, keys: tuple[str | int, ...], *, must_be: bool) -> None:
        self.name = name
        self._keys = keys
        self._must_be = must_be

    @classmethod
    def parse(cls, source: str) -> Path | None:
        """Return the path that *source* is, or None when it is another kind of template."""
        match = _PATH.fullmatch(source)
        if match is None:
            return None
        keys = tuple(
            int(index) if index else attribute or double or single
            for attribute, double, single, index in _KEY.findall(match["keys"])
        )
        return cls(match["name"], keys, must_be=match["must_be"] is not None)

    def render(self, variables: Mapping[str, object]) -> str:
        """Return the text of what is there in *variables*; see :meth:`Template.render`."""
        return self._text(variables.get(self.name, UNDEFINED))

    def render_payload(self, payload: PayloadContext) -> str:
        """Return the text of what is there in *payload*."""
        return self._text(payload.value if self.name == "value" else payload.value_json)

    def _text(self, value: object) -> str:
        for key in self._keys:
            value = value.get(key, UNDEFINED) if type(value) is dict else item(value, key)
        if self._must_be and value is UNDEFINED:
            raise NotDefinedError("the message lacks the value that the template asks for")
        return text(value)


_NAME, _DOUBLE, _SINGLE, _INDEX = "[A-Za-z_][A-Za-z0-9_]*", r'"([^"\\]*)"', r"'([^'\\]*)'", "0|[1-9][0-9]{0,4}"
_KEY = re.compile(rf"\s*(?:\.\s*({_NAME})|\[\s*(?:{_DOUBLE}|{_SINGLE}|({_INDEX}))\s*\])", re.ASCII)
_PATH = re.compile(
    r"\{\{-?\s*(?P<name>value_json|value)"
    rf"(?P<keys>(?:\s*(?:\.\s*{_NAME}|\[\s*(?:{_DOUBLE}|{_SINGLE}|{_INDEX})\s*\]))*)"
    r"\s*(?P<must_be>\|\s*is_defined\s*)?-?\}\}",
    re.ASCII,
)
