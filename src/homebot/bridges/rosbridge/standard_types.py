"""The standard types, which need not be in use, and the likely ones for an unknown name."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any, Final

from homebot import devices
from homebot.errors import PeerError
from homebot.messages import packages
from homebot.messages.action import ActionType
from homebot.messages.message import Message, ServiceType

__all__ = ["find_action", "messages_of", "services_of", "unknown_message", "unknown_service"]

_OWN_PACKAGE: Final = "homebot"
_LONGEST_TYPE: Final = 100


def messages_of(package: str) -> tuple[type[Message], ...]:
    """Return the message types of *package*."""
    if package != _OWN_PACKAGE:
        return packages.messages_of(package)
    return (
        devices.Device,
        devices.DeviceChange,
        devices.Endpoint,
        devices.RawCommand,
        devices.RawMessage,
        devices.Sighting,
    )


def services_of(package: str) -> tuple[ServiceType[Any, Any], ...]:
    """Return the service types of *package*."""
    if package != _OWN_PACKAGE:
        return packages.services_of(package)
    return (devices.FindDevices, devices.GetIndexData, devices.SubscribeToTopic)


def unknown_message(ros_type: str) -> PeerError:
    """Return the error for an unknown message type; only the likely packages are loaded for it."""
    package = ros_type.partition("/")[0][:_LONGEST_TYPE]
    likely = get_close_matches(package, (*packages.MESSAGE_PACKAGES, _OWN_PACKAGE), n=2, cutoff=0.7)
    return _unknown("message", ros_type, (one.ros_type for some in likely for one in messages_of(some)))


def unknown_service(ros_type: str) -> PeerError:
    """Return the error for an unknown service type."""
    likely = (*packages.SERVICE_PACKAGES, _OWN_PACKAGE)
    return _unknown("service", ros_type, (one.ros_type for some in likely for one in services_of(some)))


def find_action(ros_type: str) -> ActionType[Any, Any, Any]:
    """Return the standard action type *ros_type*.

    Raises:
        PeerError: There is none.
    """
    raise _unknown("action", ros_type, ())


def _unknown(kind: str, ros_type: str, known: Iterable[str]) -> PeerError:
    shown = ros_type[:_LONGEST_TYPE]  # a comparison takes the square of the length
    names = {one.rpartition("/")[2]: one for one in known}
    similar = [names[one] for one in get_close_matches(_name_in(shown), names, n=3, cutoff=0.7)]
    hint = f"; similar: {', '.join(similar)}" if similar else ""
    return PeerError(f"unknown {kind} type {shown!r}{hint}")


def _name_in(ros_type: str) -> str:
    return ros_type.partition("/")[2].removeprefix("msg/").removeprefix("srv/")
