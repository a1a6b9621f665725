"""Answers of ``/rosapi`` about the parameters of any node, ``/node:parameter``, with values as JSON text."""

import json
from collections.abc import Mapping
from typing import Any

from homebot.errors import ParameterError
from homebot.graph import Graph, ParameterSet
from homebot.messages.message import Message
from homebot.names import absolute_name
from homebot.support.names import did_you_mean
from homebot.support.strict_json import parse_strict


def get_parameter(graph: Graph, request: Any) -> Mapping[str, object]:
    """Return a value; if there is none, the caller's default."""
    try:
        parameters, name = _find(graph, request.name)
        value = parameters.get(name).value
    except ParameterError as exc:
        return {"value": request.default_value or "null", "successful": False, "reason": str(exc)}
    plain = list(value) if isinstance(value, bytes) else value
    return {"value": json.dumps(plain), "successful": True, "reason": ""}


def set_parameter(graph: Graph, request: Any) -> Mapping[str, object]:
    """Set a value."""
    try:
        parameters, name = _find(graph, request.name)
        value: Any = parse_strict(request.value)  # the parameter checks it
        if isinstance(parameters.get(name).value, bytes) and isinstance(value, list):
            value = bytes(value)
        parameters.set(name, value)
    except (ParameterError, ValueError, TypeError, RecursionError) as exc:
        return {"successful": False, "reason": f"{request.name}: {exc}"}
    return {"successful": True, "reason": ""}


def delete_parameter(graph: Graph, request: Any) -> Mapping[str, object]:
    """Refuse: a parameter belongs to the node that declared it."""
    reason = f"{request.name}: a parameter cannot be deleted; it ends with the node that declared it"
    try:
        parameters, name = _find(graph, request.name)
        parameters.get(name)
    except ParameterError as exc:
        reason = str(exc)
    return {"successful": False, "reason": reason}


def has_parameter(graph: Graph, request: Any) -> bool:
    """Return whether a parameter is declared."""
    try:
        parameters, name = _find(graph, request.name)
    except ParameterError:
        return False
    return parameters.has(name)


def list_parameters(graph: Graph, _request: Message) -> tuple[str, ...]:
    """Return all names."""
    nodes = [node for name in graph.get_node_names() if (node := graph.get_node(name)) is not None]
    return tuple(f"{node.full_name}:{name}" for node in nodes for name in node.parameters.names())


def _find(graph: Graph, full_name: str) -> tuple[ParameterSet, str]:
    node_name, colon, name = full_name.rpartition(":")
    if not colon:
        raise ParameterError(f"a parameter is named /node:parameter, got {full_name[:100]!r}")
    node = graph.get_node(absolute_name(node_name))
    if node is None:
        node_name = node_name[:100]
        hint = did_you_mean(node_name, graph.get_node_names(), "/rosapi/nodes lists all", cutoff=0.7)
        raise ParameterError(f"there is no node {node_name!r}; {hint}")
    return node.parameters, name
