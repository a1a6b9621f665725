"""Template from outside: text in, once; values in, text out, in bounded work."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, final

from homebot.conventions.payload import MAX_LONG_STATE_BYTES, parse_json
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.jinja.syntax import parse
from homebot.integrations.homeassistant.formats.jinja.values import MAX_SOURCE, UNDEFINED, TemplateError

if TYPE_CHECKING:
    from homebot.integrations.homeassistant.formats.jinja.evaluation import Program

_UNREAD = object()


@final
class PayloadContext:
    """The variables ``value`` and ``value_json`` of one message, shared by all templates that read it.

    Args:
        value: The text of the message.
    """

    __slots__ = ("_json", "value")

    def __init__(self, value: str) -> None:
        self.value = value
        self._json: object = _UNREAD

    @property
    def value_json(self) -> object:
        """JSON value of the text; :data:`UNDEFINED` for invalid JSON."""
        if self._json is _UNREAD:
            try:
                self._json = parse_json(self.value, MAX_LONG_STATE_BYTES, lenient=True)
            except WireError:
                self._json = UNDEFINED
        return self._json


@final
class Template:
    """A compiled template, made by :func:`compile_template`.

    Attributes:
        problem: Why it cannot be rendered, in words that follow "the template"; empty if it can.
    """

    __slots__ = ("_program", "problem")

    def __init__(self, source: str) -> None:
        self.problem = ""
        self._program: Program | None = None
        if len(source) > MAX_SOURCE:
            self.problem = f"is longer than {MAX_SOURCE} characters"
            return

        try:
            self._program = parse(source.strip())
        except TemplateError as error:
            self.problem = error.problem

    def render(self, variables: Mapping[str, object]) -> str:
        """Return the text of the template, without white space around it.

        Args:
            variables: The values of its names: plain values as JSON has them, never changed. A missing name is
                undefined, which is an empty text.

        Raises:
            NotDefinedError: A value is missing that ``is_defined`` requires.
            TemplateError: The template is unsupported, these values do not fit it, or it would do too much work or
                make too long a text.
        """
        return _check_text(self._check().render(variables))

    def render_value(self, payload: str | PayloadContext, variables: Mapping[str, object] | None = None) -> str:
        """Return the text of the template for a message: ``value`` is its text, ``value_json`` its JSON.

        Args:
            payload: The message; one :class:`PayloadContext` for all templates parses its JSON at most once.

        Raises:
            NotDefinedError: See :meth:`render`.
            TemplateError: See :meth:`render`.
        """
        context = PayloadContext(payload) if isinstance(payload, str) else payload
        program = self._check()
        names = {**(variables or {}), "value": context.value}
        if "value_json" in program.names:
            names["value_json"] = context.value_json
        return _check_text(program.render(names, reads_message=True))

    def _check(self) -> Program:
        if self._program is None:
            raise TemplateError(f"the template {self.problem}")
        return self._program


# A compiled template takes up to about a hundred times the memory of its text.
_MAX_CACHED_CHARACTERS = 1024
_compiled = lru_cache(maxsize=1024)(Template)


def compile_template(source: str) -> Template:
    """Return the template of *source*; never raises.

    Equal texts of up to 1,024 characters share one template, the last 1,024 of them.
    """
    return _compiled(source) if len(source) <= _MAX_CACHED_CHARACTERS else Template(source)


def _check_text(rendered: str) -> str:
    if not rendered.isascii():
        try:
            rendered.encode()
        except UnicodeEncodeError:
            raise TemplateError("the text contains half of a surrogate pair") from None
    return rendered.strip()
