"""The services of the directory by which the owner states something of devices and rooms, or decides on them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

from homebot.devices.approval_messages import ApproveDevice
from homebot.devices.names import (
    ALIAS_DEVICE,
    APPROVE_DEVICE,
    CHANGE_ROOM,
    FORGET_DEVICE,
    IMPORT_PLACES,
    MERGE_DEVICES,
    PLACE_DEVICE,
    SPLIT_DEVICE,
    TAG_DEVICE,
    TEACH_PLACE,
)
from homebot.devices.places_messages import (
    AliasDevice,
    ChangeRoom,
    ImportPlaces,
    PlaceDevice,
    TagDevice,
    TeachPlace,
)
from homebot.devices.services import ForgetDevice, MergeDevices, SplitDevice
from homebot.messages.message import ServiceType

__all__ = ["OWNER_SERVICES"]

OWNER_SERVICES: Final[Mapping[str, ServiceType[Any, Any]]] = MappingProxyType(
    {
        PLACE_DEVICE: PlaceDevice,
        ALIAS_DEVICE: AliasDevice,
        TAG_DEVICE: TagDevice,
        APPROVE_DEVICE: ApproveDevice,
        TEACH_PLACE: TeachPlace,
        CHANGE_ROOM: ChangeRoom,
        IMPORT_PLACES: ImportPlaces,
        FORGET_DEVICE: ForgetDevice,
        SPLIT_DEVICE: SplitDevice,
        MERGE_DEVICES: MergeDevices,
    }
)
"""Each by its name, with messages of any types."""
