"""Trees of templates, by Jinja's parser, within bounds."""

import warnings
from itertools import islice
from typing import Final

import jinja2
from jinja2 import nodes

from homebot.integrations.homeassistant.formats.jinja.values import MAX_DEPTH, MAX_TOKENS, TemplateError

_ENVIRONMENT: Final = jinja2.Environment(extensions=["jinja2.ext.loopcontrols"])  # noqa: S701  # only parses
_MAX_SHOWN_CHARACTERS = 60


def tree_of(source: str) -> nodes.Template:
    """Return the tree of the template *source*.

    Raises:
        TemplateError: It is none, or too large; words that follow "the template".
    """
    _check_brackets(source)
    try:
        # Python warns of texts such as '\d', which are common in regular expressions.
        with warnings.catch_warnings(action="ignore"):
            if len(source) > MAX_TOKENS and any(True for _ in islice(_ENVIRONMENT.lex(source), MAX_TOKENS, None)):
                raise TemplateError(f"has more than {MAX_TOKENS} tokens")
            return _ENVIRONMENT.parse(source)
    except jinja2.TemplateSyntaxError as error:
        raise TemplateError(f"is not a valid template: {(error.message or '')[:_MAX_SHOWN_CHARACTERS]}") from error
    except RecursionError:
        raise TemplateError("is nested too deeply") from None
    except (ValueError, OverflowError) as error:
        raise TemplateError("has a number or text that cannot be read") from error


def _check_brackets(source: str) -> None:
    if source.count("(") + source.count("[") + source.count("{") <= MAX_DEPTH:
        return
    depth = 0
    for character in source:
        if character in "([{":
            depth += 1
            if depth > MAX_DEPTH:
                raise TemplateError("is nested too deeply")
        elif character in ")]}":
            depth = max(0, depth - 1)
