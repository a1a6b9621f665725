"""Errors of a template from outside."""

from __future__ import annotations

from homebot.errors import WireError

__all__ = ["NotDefinedError", "TemplateError", "UndefinedValueError"]


class TemplateError(WireError):
    """A template gives no text: it is unsupported, or fails with these values, or would do too much work."""


class UndefinedValueError(TemplateError):
    """A template does something with a value that is not there; Jinja's ``UndefinedError``."""


class NotDefinedError(UndefinedValueError):
    """A message lacks what the template asks for with ``is_defined``: it is not meant for this reader, and no fault."""
