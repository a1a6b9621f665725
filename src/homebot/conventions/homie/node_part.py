"""A part of a Homie device in the making, named after its node. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.conventions.homie.model import HomieNode
from homebot.conventions.part_builder import BytesPart, PartBuilder
from homebot.conventions.table_codec import raw_bytes
from homebot.devices.part import Category

__all__ = ["node_part"]


def node_part(
    node: HomieNode,
    service_type: str,
    *,
    suffix: str = "",
    name: str = "",
    tag: str = "",
    category: Category = "",
    guessed: bool = False,
) -> BytesPart:
    """Return a part of *node* without capabilities.

    Args:
        node: The node.
        service_type: See :class:`homebot.devices.part.Part`, as are the last three.
        suffix: Tells it from other parts of the same node; empty for the main one.
        name: What it is called besides the node.
        tag: What kind it is of its type.
        category: Whether it is there for use, for setting up or for diagnosis.
        guessed: Whether its type was guessed.
    """
    return PartBuilder(
        raw_bytes,
        "/".join(_filled((node.id, suffix))),
        service_type,
        name=" ".join(dict.fromkeys(_filled((node.name, name)))),
        advertised=node.type,
        tag=tag,
        category=category,
        guessed=guessed,
    )


def _filled(texts: Iterable[str]) -> tuple[str, ...]:
    return tuple(text for text in texts if text)
