"""Records of the owner's statements: the fields of their messages, as JSON has them; see :mod:`homebot.cli.records`."""

from __future__ import annotations

from typing import TypedDict

from homebot.cli.records import KeyValueRecord

__all__ = [
    "AliasResponseRecord",
    "ApproveResponseRecord",
    "ChangeRoomRecord",
    "PlaceResponseRecord",
    "PlacesExportRecord",
    "PlacesImportRecord",
    "PlacesRecord",
    "RoomRecord",
    "TagResponseRecord",
    "TeachPlaceRecord",
    "UnapprovedRecord",
]


class PlaceResponseRecord(TypedDict):
    """:class:`homebot.devices.places_messages.PlaceDeviceResponse`."""

    success: bool
    message: str
    room: str
    absent: str


class AliasResponseRecord(TypedDict):
    """:class:`homebot.devices.places_messages.AliasDeviceResponse`."""

    success: bool
    message: str
    aliases: list[str]


class TagResponseRecord(TypedDict):
    """:class:`homebot.devices.places_messages.TagDeviceResponse`."""

    success: bool
    message: str
    tags: list[str]


class ApproveResponseRecord(TypedDict):
    """:class:`homebot.devices.approval_messages.ApproveDeviceResponse`."""

    success: bool
    message: str
    commands: list[str]
    changes: list[str]


class UnapprovedRecord(TypedDict):
    """:class:`homebot.devices.approval_messages.UnapprovedResponse`."""

    devices: list[str]
    reasons: list[KeyValueRecord]


class RoomRecord(TypedDict):
    """:class:`homebot.devices.places_messages.RoomInfo`."""

    name: str
    floor: str
    doors: list[str]


class PlacesRecord(TypedDict):
    """:class:`homebot.devices.places_messages.GetPlacesResponse`."""

    home: str
    rooms: list[RoomRecord]
    absent: list[KeyValueRecord]


class ChangeRoomRecord(TypedDict):
    """:class:`homebot.devices.places_messages.ChangeRoomResponse`."""

    success: bool
    message: str
    name: str


class PlacesExportRecord(TypedDict):
    """:class:`homebot.devices.places_messages.ExportPlacesResponse`."""

    text: str


class PlacesImportRecord(TypedDict):
    """:class:`homebot.devices.places_messages.ImportPlacesResponse`."""

    success: bool
    message: str
    added: list[str]
    kept: list[str]


class TeachPlaceRecord(TypedDict):
    """:class:`homebot.devices.places_messages.TeachPlaceResponse`."""

    success: bool
    message: str
    room: str
