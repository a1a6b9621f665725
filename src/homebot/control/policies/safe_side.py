"""The safe side: commands that make the house safer, which take no right that names the device. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from homebot.control.policies.command_pattern import VERBS
from homebot.devices.always_ask import is_arming, is_opener
from homebot.devices.client_rights import ClientRights
from homebot.devices.device import Device, DevicePart
from homebot.devices.trigger import Trigger
from homebot.devices.value import PlainValue

__all__ = ["is_safe", "may_make_safe"]

_SAFE: Final = ("lock", "turn off")
_OF_SETTINGS: Final = ("lock",)
"""What a setting does may make the house safer, such as the one by which a lock locks itself; off is unsafe then.

So it is of what arms the alarm, and of door openers by their model, as some move the door whichever they are told.
"""


def may_make_safe(
    rights: ClientRights, device: Device, part: DevicePart, settings: Mapping[str, PlainValue], trigger: Trigger
) -> bool:
    """Return whether *rights* without one that names *device* allow *settings* of a *part* that always asks.

    Who may command all that does not always ask may make the house safer, but not hold it so by a lease: that would
    keep those who have the right from the device.
    """
    return rights.acts_on_harmless and trigger.kind != "lease" and is_safe(device, part, settings)


def is_safe(device: Device, part: DevicePart, settings: Mapping[str, PlainValue]) -> bool:
    """Return whether all that is set makes the house safer: a valve that closes does, a door that closes may hurt."""
    is_off_unsafe = part.part.service_type == "x_setting" or is_opener(device) or is_arming(part)
    verbs = _OF_SETTINGS if is_off_unsafe else _SAFE
    return all(
        any(VERBS[verb](name, value, None) for verb in verbs)
        or value == "stopped"
        or (name, value) == ("valve", "closed")
        or (name == "alarm" and isinstance(value, str) and value.startswith("armed"))
        for name, value in settings.items()
    )
