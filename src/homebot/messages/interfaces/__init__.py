"""Interfaces of ROS by name: messages, services and actions, made of the text of their files when they are first named.

Source: ROS 2, "Interfaces" (``.msg``, ``.srv`` and ``.action`` files); rosidl, ``rosidl_adapter``.
"""

from homebot.messages.interfaces.interfaces import (
    Interfaces,
    find_action,
    find_message,
    find_service,
    interface_names,
)

__all__ = ["Interfaces", "find_action", "find_message", "find_service", "interface_names"]
