"""The services with which ROS tools read and set the parameters of a node: ``~/get_parameters`` and five others.

Loaded when one is used.

Source: ROS 2, rclpy ``parameter_service.py``, rcl_interfaces.
"""

import math
from collections.abc import Callable, Iterable
from typing import Any, Final

from homebot.errors import ParameterError
from homebot.graph.parameters import PARAMETER_SERVICES, ParameterSet, value_of
from homebot.messages.interfaces import find_message, find_service
from homebot.messages.message import Message, ServiceType

_RANGES: Final = {
    2: ("integer_range", "IntegerRange", -(2**63), 2**63 - 1),
    3: ("floating_point_range", "FloatingPointRange", -math.inf, math.inf),
}
"""The field, message and limits of the range of a number, by its type."""

# The message types are built from text, so they are typed as Any; pydantic validates each message.


def parameter_service(known: ParameterSet, name: str) -> tuple[ServiceType[Any, Any], Callable[[Any], Message]]:
    """Return the type and the handler of the service ``~/NAME`` for the parameters *known*."""
    answers: dict[str, Callable[[Any], object]] = {
        "describe_parameters": lambda request: _each(known, request, lambda name: _descriptor(known, name)),
        "get_parameter_types": lambda request: bytes(_each(known, request, lambda name: known.describe(name)[0])),
        "get_parameters": lambda request: _each(known, request, lambda name: known.get(name).to_message().value),
        "list_parameters": lambda request: _list(known, request),
        "set_parameters": lambda request: tuple(
            set_parameters(known, (parameter,)) for parameter in request.parameters
        ),
        "set_parameters_atomically": lambda request: set_parameters(known, request.parameters),
    }
    service = find_service(PARAMETER_SERVICES[name])
    return service, _handler(service.Response, answers[name])


def refusal(request: Any, response: type[Message], reason: str) -> dict[str, object]:
    """Return the fields of a *response* that sets nothing, for *reason*; empty for the services that only read."""
    kind: Any = find_message("rcl_interfaces/msg/SetParametersResult")
    result = kind(successful=False, reason=reason)
    if "results" in response.model_fields:
        return {"results": (result,) * len(request.parameters)}  # tools expect one for each
    return {"result": result} if hasattr(request, "parameters") else {}


def set_parameters(parameters: ParameterSet, given: Iterable[Any]) -> Message:
    """Set all parameters in the messages *given*, or none; return the ``SetParametersResult``."""
    result: Any = find_message("rcl_interfaces/msg/SetParametersResult")
    try:
        parameters.set_atomically({parameter.name: value_of(parameter.value) for parameter in given})
    except ParameterError as exc:
        return result(successful=False, reason=str(exc))  # type: ignore[no-any-return]
    return result(successful=True, reason="")  # type: ignore[no-any-return]


def _handler(response: type[Message], answer: Callable[[Any], object]) -> Callable[[Any], Message]:
    (field,) = response.model_fields
    return lambda request: response.model_validate({field: answer(request)})


def _each(parameters: ParameterSet, request: Any, read: Callable[[str], Any]) -> tuple[Any, ...]:
    """Return the results of *read* for all names; nothing if one is unknown, as in ROS."""
    return tuple(map(read, request.names)) if all(map(parameters.has, request.names)) else ()


def _list(parameters: ParameterSet, request: Any) -> Message:
    """Return the names below any of the prefixes, at most *depth* levels below it; 0 means any depth."""
    names = [
        name
        for name in parameters.names()
        if any(_is_below(name, prefix, request.depth) for prefix in request.prefixes or ("",))
    ]
    prefixes = sorted({name.rpartition(".")[0] for name in names if "." in name})
    kind: Any = find_message("rcl_interfaces/msg/ListParametersResult")
    return kind(names=tuple(names), prefixes=tuple(prefixes))  # type: ignore[no-any-return]


def _is_below(name: str, prefix: str, depth: int) -> bool:
    rest = name.removeprefix(f"{prefix}.") if prefix else name
    return (not prefix or name == prefix or rest != name) and (not depth or rest.count(".") < depth)


def _descriptor(parameters: ParameterSet, name: str) -> Message:
    number, given = parameters.describe(name)
    ranges: dict[str, tuple[Message, ...]] = {"floating_point_range": (), "integer_range": ()}
    if number in _RANGES and (given.minimum, given.maximum) != (None, None):
        field, ros_name, *limits = _RANGES[number]
        bounds = [
            limit if bound is None else type(limit)(bound) for bound, limit in zip(given[2:], limits, strict=True)
        ]
        span: Any = find_message(f"rcl_interfaces/msg/{ros_name}")
        ranges[field] = (span(from_value=bounds[0], to_value=bounds[1], step=type(bounds[0])(0)),)
    fields = {"name": name, "type": number, "description": given.description, "read_only": given.read_only}
    descriptor = find_message("rcl_interfaces/msg/ParameterDescriptor")
    return descriptor.model_validate({**fields, **ranges, "additional_constraints": "", "dynamic_typing": False})
