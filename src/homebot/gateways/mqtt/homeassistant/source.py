"""Where a part says a value, and how the value is found in the message. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.gateways.mqtt.homeassistant.said import Said
from homebot.gateways.mqtt.templates import Template, TemplateError

__all__ = ["Source"]


@dataclass(frozen=True, slots=True)
class Source:
    """One topic that a part speaks on, and the template that finds one value there.

    Attributes:
        topic: A topic, or a filter where the device declared one.
        template: Finds the value; None where the whole payload is the value.
        encoding: Of the payload; see :attr:`Config.encoding`.
        variables: What else the template may name.
    """

    topic: str
    template: Template | None = None
    encoding: str = "utf-8"
    variables: Mapping[str, object] | None = None

    @property
    def problem(self) -> str:
        """Why the template cannot be used; empty where it can."""
        return self.template.problem if self.template is not None else ""

    def text(self, said: Said) -> str | None:
        """Return the value as Home Assistant would compare it; None where the message is to be ignored."""
        context = said.context(self.encoding)
        if context is None:
            return None
        if self.template is None:
            return context.value
        try:
            return self.template.render_value(context, self.variables)
        except TemplateError:
            return None
