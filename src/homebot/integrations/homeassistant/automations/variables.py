"""Values that are written elsewhere: variables, inputs of blueprints, and parts in other files. Pure."""

import re
from ast import literal_eval
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Final, Self

from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.integrations.homeassistant.formats.jinja.syntax import parse
from homebot.integrations.homeassistant.formats.jinja.values import TemplateError, Undefined
from homebot.support.located import Located

_MAX_DEPTH: Final = 20
_MAX_LIST: Final = 10_000
"""Characters of a list that a template makes."""


def resolved(node: Located, constants: Mapping[str, object]) -> Located:
    """Return *node* with the values of templates that are made of *constants* alone.

    Args:
        constants: Located or plain values, by name.
    """
    value = node.value
    if node.tag or not constants:
        return node
    if not isinstance(value, str) or "{" not in value:
        return _with_parts(node, lambda inner: resolved(inner, constants))
    name = value.strip().removeprefix("{{").removesuffix("}}").strip()
    if (known := _known(name, constants)) is not None and not isinstance(plain(known), Undefined):
        return known._replace(line=node.line) if isinstance(known, Located) else Located(known, node.line)
    given = value.values if isinstance(value, BoundTemplate) else {}
    plain_values = {**{name: plain(value) for name, value in constants.items()}, **given}
    program = None
    with suppress(TemplateError):
        program = parse(value.strip())
    if program is None or program.names - plain_values.keys():
        return node._replace(value=BoundTemplate.of(value, plain_values))
    try:
        return _rendered(node, program.render(plain_values).strip()) if program.names else node
    except TemplateError:
        return node


def _with_parts(node: Located, change: Callable[[Located], Located]) -> Located:
    """Return *node* with its changed fields, or elements."""
    if isinstance(node.value, dict):
        return node._replace(value={key: change(inner) for key, inner in node.value.items()})
    return node._replace(value=[*map(change, node.value)]) if isinstance(node.value, list) else node


_ID_OF_RUN: Final = re.compile(r"\{\{ ?(?:['\"](\w*)['\"] ?~ ?)?context\.id ?\}\}")


def without_run_id(node: Located) -> Located:
    """Return *node* without the id of the run at the end of texts: those of all runs are one button in homebot."""
    if isinstance(node.value, str):
        return node._replace(value=_ID_OF_RUN.sub(r"\1", node.value))
    return _with_parts(node, without_run_id)


def _known(name: str, constants: Mapping[str, object]) -> object:
    """Return the value *name*, such as ``repeat.item``, as it stands in *constants*; None for an unknown one."""
    if name in constants:
        return constants[name]
    first, _, field = name.partition(".")
    inner = constants.get(first)
    return inner.get(field) if isinstance(inner, dict) else None


def _rendered(node: Located, text: str) -> Located:
    """Return *node* with the value *text*, which may be a list."""
    if text[:1] != "[" or len(text) > _MAX_LIST:
        return node._replace(value=text)
    try:
        values = literal_eval(text)
    except (ValueError, SyntaxError):
        return node._replace(value=text)
    is_plain = all(isinstance(value, str | int | float) for value in values)
    return node._replace(value=[Located(value, node.line) for value in values] if is_plain else text)


class BoundTemplate(str):
    """A template with the values of some of its variables."""

    values: Mapping[str, object]
    __slots__ = ("values",)

    @classmethod
    def of(cls, text: str, values: Mapping[str, object]) -> Self:
        """Return *text* with *values*, beside those that it has."""
        template = cls(text)
        template.values = {**values, **text.values} if isinstance(text, BoundTemplate) else values
        return template


def plain(value: object) -> object:
    """Return a located value without its lines."""
    if isinstance(value, Located):
        return plain(value.value)
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    return [plain(inner) for inner in value] if isinstance(value, list) else value


def is_constant(node: Located) -> bool:
    """Return whether *node* has no template."""
    if isinstance(node.value, dict):
        return all(map(is_constant, node.value.values()))
    if isinstance(node.value, list):
        return all(map(is_constant, node.value))
    return not (isinstance(node.value, str) and "{" in node.value)


def replaced(node: Located, tag: str, value_of: Callable[[Located], Located], depth: int = 0) -> Located:
    """Return *node* with the values of *value_of* for all with *tag*.

    Raises:
        NotCarriedError: They contain each other, or *value_of* raises it.
    """
    if depth > _MAX_DEPTH:
        raise NotCarriedError(f"{tag} too deep in others", node.line)
    if node.tag == tag:
        return replaced(value_of(node), tag, value_of, depth + 1)
    return _with_parts(node, lambda inner: replaced(inner, tag, value_of, depth))
