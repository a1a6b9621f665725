"""Templates of announcements, in a bounded subset of Jinja2 as Home Assistant has it."""

from homebot.integrations.homeassistant.formats.jinja.template import PayloadContext, Template, compile_template
from homebot.integrations.homeassistant.formats.jinja.values import NotDefinedError, TemplateError, UndefinedValueError

__all__ = [
    "NotDefinedError",
    "PayloadContext",
    "Template",
    "TemplateError",
    "UndefinedValueError",
    "compile_template",
]
