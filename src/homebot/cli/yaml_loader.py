"""The loader of PyYAML with the core schema of YAML 1.2, in which ``on`` and ``yes`` are texts.

Source: YAML 1.2.2, section 10.3.2 (tag resolution).
"""

import re
from collections.abc import Callable, Hashable
from itertools import count as count_from
from typing import Final, TypeVar

import yaml

from homebot.errors import WireError
from homebot.support.located import Located

T = TypeVar("T")

MAX_READ: Final = 1_000_000
"""Characters of a document, and values with their lines; so many take seconds."""


def load_yaml(text: str) -> object:
    """Return the value of a document of YAML.

    Raises:
        WireError: It is none; the message begins with the place.
    """
    return _load(lambda: yaml.load(text, _CoreLoader))  # noqa: S506 - it makes plain values alone


def load_located(text: str) -> Located:
    """Return the values of a document of YAML with their lines; own tags are kept, and aliases are values.

    Raises:
        WireError: As for :func:`load_yaml`, or it is too long.
    """
    if len(text) > MAX_READ:
        raise WireError(f"it has {len(text):,} characters; divide it, as {MAX_READ:,} are read at once")
    loader = _LocatedLoader(text)
    count = count_from(1)

    def own_tag(node: yaml.Node) -> str:
        return node.tag if node.tag.startswith("!") else ""

    def located(node: yaml.Node | None) -> Located:
        line = 1 if node is None else node.start_mark.line + 1
        if next(count) > MAX_READ:
            raise WireError("its aliases (*NAME) repeat too much; write the values themselves there")
        match node:
            case yaml.MappingNode():
                names = loader.construct_mapping(yaml.MappingNode(node.tag, [(key, key) for key, _ in node.value]))
                values = [located(value) for _, value in node.value]
                return Located(dict(zip(names, values, strict=True)), line, own_tag(node))
            case yaml.SequenceNode():
                return Located([located(item) for item in node.value], line, own_tag(node))
            case yaml.ScalarNode(value=value) if own_tag(node):
                return Located(value, line, own_tag(node))
        return Located(None if node is None else loader.construct_object(node), line)

    return _load(lambda: located(loader.get_single_node()))


def _load(load: Callable[[], T]) -> T:
    try:
        return load()
    except yaml.MarkedYAMLError as exc:
        mark = exc.problem_mark
        where = f"line {mark.line + 1}, column {mark.column + 1}: " if mark is not None else ""
        raise WireError(f"{where}{exc.problem}") from exc
    except (ValueError, RecursionError, yaml.YAMLError) as exc:
        raise WireError(str(exc).partition("\n")[0]) from exc


class _CoreLoader(yaml.SafeLoader):
    """Makes dicts with texts as keys, lists and plain values."""

    yaml_implicit_resolvers = {}  # noqa: RUF012 - as PyYAML declares it

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Refuse aliases, which can expand a short text to any size."""
        if self.check_event(yaml.AliasEvent):
            mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
            raise yaml.MarkedYAMLError(None, None, "it has an alias (*NAME): write the value itself there", mark)
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, object]:  # noqa: FBT001, FBT002 - PyYAML's
        """Return the fields; their names are texts."""
        del deep
        mapping: dict[Hashable, object] = {}
        for key, value in node.value:
            name = self.construct_scalar(key)
            if name in mapping:
                raise yaml.MarkedYAMLError(None, None, f"the field {name[:60]!r} occurs twice", key.start_mark)
            mapping[name] = self.construct_object(value, deep=True)
        return mapping


class _LocatedLoader(_CoreLoader):
    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        return yaml.SafeLoader.compose_node(self, parent, index)


for _tag, _shape, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?[0-9]{1,999}", list("-+0123456789")),
    ("float", r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?", list("-+0123456789.")),
    ("float", r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)", list("-+.")),
):
    _CoreLoader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"(?:{_shape})\\Z"), _first)


def _integer(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> int:
    return int(loader.construct_scalar(node))  # in YAML 1.1, 010 is 8


_CoreLoader.add_constructor("tag:yaml.org,2002:int", _integer)
