"""ROS interfaces by name: messages, services and actions, built from the text of their files on first use.

Source: ROS 2, "Interfaces" (``.msg``, ``.srv`` and ``.action`` files); rosidl, ``rosidl_adapter``.
"""

from homebot.messages.interfaces.interfaces import Interfaces as Interfaces
from homebot.messages.interfaces.interfaces import find_action as find_action
from homebot.messages.interfaces.interfaces import find_message as find_message
from homebot.messages.interfaces.interfaces import find_service as find_service
from homebot.messages.interfaces.interfaces import interface_names as interface_names
