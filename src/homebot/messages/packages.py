"""The messages and services of ROS by package, each package loaded when one of its types is first used."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from importlib import import_module
from typing import Any, Final

from homebot.messages.message import Message, ServiceType

__all__ = ["MESSAGE_PACKAGES", "SERVICE_PACKAGES", "messages_of", "services_of"]

MESSAGE_PACKAGES: Final = (
    "action_msgs",
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "nav_msgs",
    "rcl_interfaces",
    "rosgraph_msgs",
    "sensor_msgs",
    "std_msgs",
    "tf2_msgs",
    "unique_identifier_msgs",
)
"""The packages that have messages, each the module of that name here."""

SERVICE_PACKAGES: Final = ("action_msgs", "example_interfaces", "std_srvs")
"""The packages that have services, each the module of that name here."""


@lru_cache
def messages_of(package: str) -> tuple[type[Message], ...]:
    """Return the message types of *package*, none where it is not one of :data:`MESSAGE_PACKAGES`."""
    if package not in MESSAGE_PACKAGES:
        return ()
    return tuple(one for one in _names_in(package) if isinstance(one, type) and issubclass(one, Message))


@lru_cache
def services_of(package: str) -> tuple[ServiceType[Any, Any], ...]:  # the messages of a service may be any
    """Return the service types of *package*, none where it is not one of :data:`SERVICE_PACKAGES`."""
    if package not in SERVICE_PACKAGES:
        return ()
    return tuple(one for one in _names_in(package) if isinstance(one, ServiceType))


def _names_in(package: str) -> Iterator[object]:
    module = import_module(f"homebot.messages.{package}")
    return (getattr(module, name) for name in module.__all__)
