"""A template of a stranger: text in, once; values in, text out, in bounded work."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import datetime
from functools import lru_cache
from typing import TYPE_CHECKING, final

from homebot.conventions.jinja.limits import MAX_SOURCE, MAX_TEXT, NotDefinedError, TemplateError
from homebot.conventions.jinja.values import UNDEFINED, item, text
from homebot.conventions.payload import MAX_LONG_STATE_BYTES, parse_json
from homebot.errors import WireError

if TYPE_CHECKING:
    from homebot.conventions.jinja.statements import Program

__all__ = ["Path", "PayloadContext", "Template", "compile_template"]


@final
class PayloadContext:
    """The variables ``value`` and ``value_json`` of one message, to be shared by all templates that read it.

    Args:
        value: The text of the message.
    """

    __slots__ = ("_json", "value")

    def __init__(self, value: str) -> None:
        self.value = value
        self._json: object = _UNREAD

    @property
    def value_json(self) -> object:
        """JSON value of the text; :data:`UNDEFINED` where it is none that our border lets in."""
        if self._json is _UNREAD:
            try:
                self._json = parse_json(self.value, MAX_LONG_STATE_BYTES)
            except WireError:
                self._json = UNDEFINED
        return self._json


_UNREAD = object()


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
        """Return the text for *variables*; see :meth:`Template.render`."""
        return self._text(variables.get(self.name, UNDEFINED))

    def render_payload(self, payload: PayloadContext) -> str:
        """Return the text for *payload*."""
        return self._text(payload.value if self.name == "value" else payload.value_json)

    def _text(self, value: object) -> str:
        for key in self._keys:
            value = value.get(key, UNDEFINED) if type(value) is dict else item(value, key)
        if self._must_be and value is UNDEFINED:
            raise NotDefinedError("the message lacks the value that the template uses")
        return text(value)


_NAME, _DOUBLE, _SINGLE, _INDEX = "[A-Za-z_][A-Za-z0-9_]*", r'"([^"\\]*)"', r"'([^'\\]*)'", "0|[1-9][0-9]{0,4}"
_KEY = re.compile(rf"\s*(?:\.\s*({_NAME})|\[\s*(?:{_DOUBLE}|{_SINGLE}|({_INDEX}))\s*\])", re.ASCII)
_PATH = re.compile(
    r"\{\{-?\s*(?P<name>value_json|value)"
    rf"(?P<keys>(?:\s*(?:\.\s*{_NAME}|\[\s*(?:{_DOUBLE}|{_SINGLE}|{_INDEX})\s*\]))*)"
    r"\s*(?P<must_be>\|\s*is_defined\s*)?-?\}\}",
    re.ASCII,
)


@final
class Template:
    """A compiled template; get one from :func:`compile_template`.

    Attributes:
        source: Its text.
        problem: Why it cannot be rendered, in words that follow "the template"; empty when it can.
    """

    __slots__ = ("_path", "_program", "problem", "source")

    def __init__(self, source: str) -> None:
        self.source = source
        self.problem = ""
        self._program: Program | None = None
        if len(source) > MAX_SOURCE:
            self._path: Path | None = None
            self.problem = f"is longer than {MAX_SOURCE} characters"
            return
        stripped = source.strip()
        self._path = Path.parse(stripped)
        if self._path is None:
            from homebot.conventions.jinja.syntax import parse  # noqa: PLC0415 - nine in ten are paths: no Jinja2

            try:
                self._program = parse(stripped)
            except TemplateError as error:
                self.problem = error.problem

    def render(self, variables: Mapping[str, object], *, now: datetime | None = None) -> str:
        """Return the text that the template gives, without white space around it.

        Args:
            variables: The values of its names: plain values as JSON has them, never changed. A missing name is
                undefined, which is an empty text.
            now: The time, with its time zone, for ``now()`` and local times; without it these fail.

        Raises:
            NotDefinedError: Something that ``is_defined`` asks for is not there.
            TemplateError: The template is unsupported, these values do not fit it, or it would do too much work or
                make too long a text.
        """
        if self._path is not None:
            return _bounded(self._path.render(variables))
        return _bounded(self._checked().render(variables, now))

    def render_value(
        self,
        payload: str | PayloadContext,
        variables: Mapping[str, object] | None = None,
        *,
        now: datetime | None = None,
    ) -> str:
        """Return the text that the template gives for a message: ``value`` is its text, ``value_json`` its JSON.

        Args:
            payload: The message. Give the same :class:`PayloadContext` to all templates that read it, so that its
                JSON is read at most once.
            variables: Further names.
            now: See :meth:`render`.

        Raises:
            NotDefinedError: See :meth:`render`.
            TemplateError: See :meth:`render`.
        """
        if isinstance(payload, str):
            payload = PayloadContext(payload)
        if self._path is not None:
            return _bounded(self._path.render_payload(payload))
        program = self._checked()
        names: dict[str, object] = dict(variables) if variables else {}
        names["value"] = payload.value
        if "value_json" in program.names:
            names["value_json"] = payload.value_json
        return _bounded(program.render(names, now))

    def _checked(self) -> Program:
        if self._program is None:
            raise TemplateError(f"the template {self.problem}")
        return self._program


def compile_template(source: str) -> Template:
    """Return the template that *source* is; never raises.

    Equal texts of up to 1,024 characters share one template, the last 1,024 of them.
    """
    return _compiled(source) if len(source) <= _LONGEST_KEPT else Template(source)


# A compiled template takes up to about a hundred times the memory of its text.
_LONGEST_KEPT = 1024
_compiled = lru_cache(maxsize=1024)(Template)


def _bounded(rendered: str) -> str:
    if len(rendered) > MAX_TEXT:
        raise TemplateError(f"the text is longer than {MAX_TEXT} characters")
    if not rendered.isascii():
        try:
            rendered.encode()
        except UnicodeEncodeError:
            raise TemplateError("the text contains half of a surrogate pair") from None
    return rendered.strip()
