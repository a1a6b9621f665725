"""Services of ``/rosapi`` about the parameters of any node, ``/node:parameter``, with values as JSON text.

Source: RobotWebTools rosbridge_suite, branch ros2, ``rosapi_msgs/srv`` and ``rosapi_msgs/msg``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from homebot.errors import ParameterError
from homebot.graph import Graph, ParameterSet
from homebot.messages.message import Message
from homebot.support.strict_json import parse_strict

__all__ = ["SERVICES"]


class GetParamRequest(Message, ros_type="rosapi_msgs/srv/GetParam_Request"):
    """A question for the value of the parameter ``/node:name``."""

    name: str
    default_value: str = ""


class GetParamResponse(Message, ros_type="rosapi_msgs/srv/GetParam_Response"):
    """Its value as JSON text; ``null`` and the reason where there is none."""

    value: str
    successful: bool
    reason: str


class SetParamRequest(Message, ros_type="rosapi_msgs/srv/SetParam_Request"):
    """Give the parameter ``/node:name`` a value, written as JSON text."""

    name: str
    value: str


class SetParamResponse(Message, ros_type="rosapi_msgs/srv/SetParam_Response"):
    """The result of setting a parameter, with the reason of a refusal."""

    successful: bool
    reason: str


class DeleteParamRequest(Message, ros_type="rosapi_msgs/srv/DeleteParam_Request"):
    """Delete the parameter ``/node:name``."""

    name: str


class DeleteParamResponse(Message, ros_type="rosapi_msgs/srv/DeleteParam_Response"):
    """The result of deleting a parameter, with the reason of a refusal."""

    successful: bool
    reason: str


class HasParamRequest(Message, ros_type="rosapi_msgs/srv/HasParam_Request"):
    """Is there a parameter ``/node:name``?"""

    name: str


class HasParamResponse(Message, ros_type="rosapi_msgs/srv/HasParam_Response"):
    """The answer to :class:`HasParamRequest`."""

    exists: bool


class GetParamNamesRequest(Message, ros_type="rosapi_msgs/srv/GetParamNames_Request"):
    """A question for the names of all parameters."""


class GetParamNamesResponse(Message, ros_type="rosapi_msgs/srv/GetParamNames_Response"):
    """Their names, as ``/node:name``."""

    names: tuple[str, ...]


def get_parameter(graph: Graph, request: GetParamRequest) -> GetParamResponse:
    """Return a value; where there is none, the caller's default."""
    try:
        parameters, name = _find(graph, request.name)
        value = parameters.get(name).value
    except ParameterError as exc:
        return GetParamResponse(value=request.default_value or "null", successful=False, reason=str(exc))
    plain = list(value) if isinstance(value, bytes) else value
    return GetParamResponse(value=json.dumps(plain), successful=True, reason="")


def set_parameter(graph: Graph, request: SetParamRequest) -> SetParamResponse:
    """Set a value."""
    try:
        parameters, name = _find(graph, request.name)
        value: Any = parse_strict(request.value)  # the parameter checks it
        if isinstance(parameters.get(name).value, bytes) and isinstance(value, list):
            value = bytes(value)
        parameters.set(name, value)
    except (ParameterError, ValueError, TypeError, RecursionError) as exc:
        return SetParamResponse(successful=False, reason=f"{request.name}: {exc}")
    return SetParamResponse(successful=True, reason="")


def delete_parameter(graph: Graph, request: DeleteParamRequest) -> DeleteParamResponse:
    """Refuse: a parameter belongs to the node that declared it."""
    reason = f"{request.name}: a parameter cannot be deleted; it ends with the node that declared it"
    try:
        parameters, name = _find(graph, request.name)
        parameters.get(name)
    except ParameterError as exc:
        reason = str(exc)
    return DeleteParamResponse(successful=False, reason=reason)


def has_parameter(graph: Graph, request: HasParamRequest) -> HasParamResponse:
    """Return whether a parameter is declared."""
    try:
        parameters, name = _find(graph, request.name)
    except ParameterError:
        return HasParamResponse(exists=False)
    return HasParamResponse(exists=parameters.has(name))


def list_parameters(graph: Graph, _request: GetParamNamesRequest) -> GetParamNamesResponse:
    """Return all names."""
    nodes = [node for name in graph.get_node_names() if (node := graph.get_node(name)) is not None]
    names = (f"{node.full_name}:{name}" for node in nodes for name in node.parameters.names())
    return GetParamNamesResponse(names=tuple(names))


def _find(graph: Graph, full_name: str) -> tuple[ParameterSet, str]:
    node_name, colon, name = full_name.rpartition(":")
    if not colon:
        raise ParameterError(f"a parameter is named /node:parameter, got {full_name[:100]!r}")
    node = graph.get_node(node_name if node_name.startswith("/") else f"/{node_name}")
    if node is None:
        raise ParameterError(f"there is no node {node_name[:100]!r}")
    return node.parameters, name


SERVICES: Mapping[str, tuple[type[Message], type[Message], Callable[[Graph, Any], Message]]] = {
    "get_param": (GetParamRequest, GetParamResponse, get_parameter),
    "set_param": (SetParamRequest, SetParamResponse, set_parameter),
    "delete_param": (DeleteParamRequest, DeleteParamResponse, delete_parameter),
    "has_param": (HasParamRequest, HasParamResponse, has_parameter),
    "get_param_names": (GetParamNamesRequest, GetParamNamesResponse, list_parameters),
}
"""Request, response and function of each service, by its name below ``/rosapi``."""
