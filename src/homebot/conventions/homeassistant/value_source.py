"""Source of a part's value: the topic, and the way to find the value in its message. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from homebot.conventions.homeassistant.incoming import StateMessage
from homebot.conventions.jinja import Template, TemplateError, UndefinedValueError

__all__ = ["ValueSource"]


@dataclass(frozen=True, slots=True)
class ValueSource:
    """One topic that a part speaks on, and the template that finds one value there.

    Attributes:
        topic: A topic, or a filter where the device declared one.
        template: Finds the value; None where the whole payload is the value.
        encoding: Of the payload; see :attr:`DiscoveryConfig.encoding`.
        variables: What else the template may name.
        or_payload: Whether the payload itself is the value where the template wants what is not in it, for example
            because it is no JSON. Home Assistant has it so for all but a few values.
    """

    topic: str
    template: Template | None = None
    encoding: str = "utf-8"
    variables: Mapping[str, object] | None = None
    or_payload: bool = True

    @property
    def problem(self) -> str:
        """Reason why the template cannot be used; empty where it can."""
        return self.template.problem if self.template is not None else ""

    def text(self, message: StateMessage) -> str | None:
        """Return the value as Home Assistant would compare it; None where the message is to be ignored."""
        context = message.context(self.encoding)
        if context is None:
            return None
        if self.template is None:
            return context.value
        try:
            return self.template.render_value(context, self.variables)
        except UndefinedValueError:
            return context.value if self.or_payload else None
        except TemplateError:
            return None

    def without_payload(self) -> ValueSource:
        """Return the same, but a message that lacks what the template wants tells nothing."""
        return replace(self, or_payload=False)
