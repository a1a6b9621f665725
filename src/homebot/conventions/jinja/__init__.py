"""Templates that strangers announce, in the language of Jinja2 as Home Assistant has it: a bounded subset."""

from homebot.conventions.jinja.limits import NotDefinedError, TemplateError, UndefinedValueError
from homebot.conventions.jinja.template import PayloadContext, Template, compile_template

__all__ = ["NotDefinedError", "PayloadContext", "Template", "TemplateError", "UndefinedValueError", "compile_template"]
