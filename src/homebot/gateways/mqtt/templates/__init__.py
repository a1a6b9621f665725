"""Templates that strangers announce, in the language of Jinja2 as Home Assistant has it: a bounded subset."""

from homebot.gateways.mqtt.templates.errors import NotDefinedError, TemplateError, UndefinedValueError
from homebot.gateways.mqtt.templates.payload_context import PayloadContext
from homebot.gateways.mqtt.templates.template import Template, compile_template

__all__ = ["NotDefinedError", "PayloadContext", "Template", "TemplateError", "UndefinedValueError", "compile_template"]
