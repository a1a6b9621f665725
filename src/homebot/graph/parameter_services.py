"""The services by which ROS's tools read and set the parameters of a node: ``~/get_parameters`` and five others.

Source: ROS 2, rclpy ``parameter_service.py``, rcl_interfaces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

from homebot.errors import ParameterError
from homebot.graph.endpoint import EntityKind
from homebot.graph.node import Node
from homebot.graph.parameters import ParameterSet, value_of
from homebot.messages.interfaces import find_message, find_service
from homebot.messages.message import Message

__all__ = ["offer_parameter_services", "set_parameters"]

_INTEGER: Final = 2
_DOUBLE: Final = 3

# The messages are of types made of text, so they are any; pydantic checks them where they are made.


def offer_parameter_services(node: Node) -> None:
    """Offer the parameters of *node* by ROS's services, unless it does so already. They end with the node."""
    if node.graph.get_endpoints(kind=EntityKind.SERVICE, name=f"{node.full_name}/list_parameters"):
        return
    for name, (ros_name, answer) in _SERVICES.items():
        service = find_service(f"rcl_interfaces/srv/{ros_name}")
        node.create_service(service, f"~/{name}", partial(_respond, service.Response, answer, node.parameters))


def _respond(
    response: type[Message],
    answer: Callable[[ParameterSet, Any], Mapping[str, object]],
    parameters: ParameterSet,
    request: Any,
) -> Message:
    return response(**answer(parameters, request))


def _get(parameters: ParameterSet, request: Any) -> Mapping[str, object]:
    """Return the values; with an unknown name none, as in ROS."""
    known = all(map(parameters.has, request.names))
    return {"values": tuple(parameters.get(name).to_message().value for name in request.names) if known else ()}


def _get_types(parameters: ParameterSet, request: Any) -> Mapping[str, object]:
    known = all(map(parameters.has, request.names))
    return {"types": bytes(parameters.describe(name)[0] for name in request.names) if known else b""}


def _list(parameters: ParameterSet, request: Any) -> Mapping[str, object]:
    """Return the names below any of the prefixes, at most *depth* parts below it; 0 is any depth."""
    found = [
        name
        for name in parameters.names()
        if any(_is_below(name, prefix, request.depth) for prefix in request.prefixes or ("",))
    ]
    prefixes = sorted({name.rpartition(".")[0] for name in found if "." in name})
    kind: Any = find_message("rcl_interfaces/msg/ListParametersResult")
    return {"result": kind(names=tuple(found), prefixes=tuple(prefixes))}


def _is_below(name: str, prefix: str, depth: int) -> bool:
    rest = name.removeprefix(f"{prefix}.") if prefix else name
    return (not prefix or name == prefix or rest != name) and (not depth or rest.count(".") < depth)


def _describe(parameters: ParameterSet, request: Any) -> Mapping[str, object]:
    """Return the descriptors; with an unknown name none, as in ROS."""
    known = all(map(parameters.has, request.names))
    return {"descriptors": tuple(_descriptor(parameters, name) for name in request.names) if known else ()}


def _descriptor(parameters: ParameterSet, name: str) -> Message:
    number, given = parameters.describe(name)
    low, high = given.minimum, given.maximum
    ranges: dict[str, tuple[Message, ...]] = {"floating_point_range": (), "integer_range": ()}
    if low is not None and high is not None and number in {_INTEGER, _DOUBLE}:
        field, ros_name, kind = (
            ("integer_range", "IntegerRange", int)
            if number == _INTEGER
            else ("floating_point_range", "FloatingPointRange", float)
        )
        span: Any = find_message(f"rcl_interfaces/msg/{ros_name}")
        ranges[field] = (span(from_value=kind(low), to_value=kind(high), step=kind(0)),)
    descriptor: Any = find_message("rcl_interfaces/msg/ParameterDescriptor")
    return descriptor(  # type: ignore[no-any-return]
        name=name,
        type=number,
        description=given.description,
        additional_constraints=_one_limit(low, high),
        read_only=given.read_only,
        dynamic_typing=False,
        **ranges,
    )


def _one_limit(low: float | None, high: float | None) -> str:
    """Return in words a limit that stands alone, for which ROS's ranges have no form."""
    if (low is None) == (high is None):
        return ""
    return f"at most {high:g}" if low is None else f"at least {low:g}"


def _set(parameters: ParameterSet, request: Any) -> Mapping[str, object]:
    return {"results": tuple(set_parameters(parameters, (one,)) for one in request.parameters)}


def _set_atomically(parameters: ParameterSet, request: Any) -> Mapping[str, object]:
    return {"result": set_parameters(parameters, request.parameters)}


def set_parameters(parameters: ParameterSet, given: tuple[Any, ...]) -> Message:
    """Set all parameters in the messages *given*, or none; return the ``SetParametersResult``."""
    result: Any = find_message("rcl_interfaces/msg/SetParametersResult")
    try:
        parameters.set_atomically({one.name: value_of(one.value) for one in given})
    except ParameterError as exc:
        return result(successful=False, reason=str(exc))  # type: ignore[no-any-return]
    return result(successful=True, reason="")  # type: ignore[no-any-return]


_SERVICES: Final = {
    "describe_parameters": ("DescribeParameters", _describe),
    "get_parameter_types": ("GetParameterTypes", _get_types),
    "get_parameters": ("GetParameters", _get),
    "list_parameters": ("ListParameters", _list),
    "set_parameters": ("SetParameters", _set),
    "set_parameters_atomically": ("SetParametersAtomically", _set_atomically),
}
