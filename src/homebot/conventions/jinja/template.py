"""A template of a stranger: text in, once; values in, text out, in bounded work."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from functools import lru_cache
from typing import TYPE_CHECKING, final

from homebot.conventions.jinja.errors import TemplateError
from homebot.conventions.jinja.limits import MAX_SOURCE, MAX_TEXT
from homebot.conventions.jinja.path import Path
from homebot.conventions.jinja.payload_context import PayloadContext

if TYPE_CHECKING:
    from homebot.conventions.jinja.program import Program

__all__ = ["Template", "compile_template"]


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
            variables: What its names mean: plain values as JSON has them, never changed. A name that is not there is
                undefined, which is an empty text.
            now: The time, with its time zone, for ``now()`` and what is local; without it these fail.

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


# What a template is compiled to takes up to about a hundred times the memory of its text.
_LONGEST_KEPT = 1024
_compiled = lru_cache(maxsize=1024)(Template)


def _bounded(rendered: str) -> str:
    if len(rendered) > MAX_TEXT:
        raise TemplateError(f"the text is longer than {MAX_TEXT} characters")
    if not rendered.isascii():
        try:
            rendered.encode()
        except UnicodeEncodeError:
            raise TemplateError("the text has half a surrogate pair") from None
    return rendered.strip()
