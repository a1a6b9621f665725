"""Topic and payload of a command. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.conventions.description import Publication
from homebot.conventions.jinja import Template, TemplateError
from homebot.errors import RefusedError

__all__ = ["CommandTopic"]

_NO_VARIABLES: Mapping[str, object] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class CommandTopic:
    """One topic that a part listens on.

    Attributes:
        topic: The topic.
        template: Makes the payload of the value; None where the value itself is the payload.
        qos: As the config says.
        retain: As the config says; never true unless it does.
        encoding: Of the payload; UTF-8 where it is empty.
    """

    topic: str
    template: Template | None = None
    qos: int = 0
    retain: bool = False
    encoding: str = "utf-8"

    def publication(self, value: object, variables: Mapping[str, object] = _NO_VARIABLES) -> Publication:
        """Return what to publish to tell *value*.

        Args:
            value: The payload as Python spells it, or what the template calls ``value``.
            variables: What else the template may name.

        Raises:
            RefusedError: The template cannot be used, fails on this value, or makes what cannot be encoded.
        """
        text = str(value) if self.template is None else self._rendered(self.template, {"value": value, **variables})
        try:
            payload = text.encode(self.encoding or "utf-8")
        except UnicodeEncodeError:
            raise RefusedError(f"a command on {self.topic}", f"it cannot be written in {self.encoding}") from None
        return Publication(self.topic, payload, self.qos, self.retain)

    def publication_with_code(
        self, value: object, code: str, variables: Mapping[str, object] = _NO_VARIABLES
    ) -> Publication:
        """As :meth:`publication`, with a *code* that the template may name; no error shows it.

        Raises:
            RefusedError: As there.
        """
        try:
            return self.publication(value, {**variables, "code": code or None})
        except RefusedError:
            if not code:
                raise
            raise RefusedError(f"a command on {self.topic}", "its template failed with this code") from None

    def _rendered(self, template: Template, variables: Mapping[str, object]) -> str:
        if template.problem:
            raise RefusedError(f"a command on {self.topic}", f"its template {template.problem}")
        try:
            return template.render(variables)
        except TemplateError as error:
            raise RefusedError(f"a command on {self.topic}", f"its template failed: {error}") from None
