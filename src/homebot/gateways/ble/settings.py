"""The table ``[gateways.NAME]`` of a Bluetooth gateway."""

from __future__ import annotations

import re
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from homebot.config import SecretFile, SecretName
from homebot.conventions.bluetooth.gatt_profile import GattProfile
from homebot.conventions.bluetooth.signal import RSSI_AT_1M
from homebot.errors import UsageError
from homebot.gateways.base import GatewaySettings
from homebot.gateways.ble_proxies.settings import BleProxySettings
from homebot.gateways.password_settings import read_password
from homebot.plugins import plugin_names
from homebot.units import Seconds

PARSERS = "homebot.ble_parsers"
"""The plug-in group of parsers."""

Listed: TypeAlias = Literal["understood", "named", "all"]
"""Which devices are listed; see :class:`BleGatewaySettings`."""

_ADDRESS = re.compile(r"[0-9A-F]{2}(:[0-9A-F]{2}){5}|[0-9A-F]{8}(-[0-9A-F]{4}){3}-[0-9A-F]{12}")
_KEY = re.compile(r"[0-9a-fA-F]{24}|[0-9a-fA-F]{32}")


def _address(text: str) -> str:
    spelled = text.strip().upper()
    if not _ADDRESS.fullmatch(spelled):
        raise ValueError(f"{text!r} is not an address; write it like A4:C1:38:0A:0B:0C")
    return spelled


Address: TypeAlias = Annotated[str, AfterValidator(_address)]


class BleDeviceSettings(BaseModel):
    """The table ``[gateways.NAME.devices."ADDRESS"]``: facts that a device does not advertise.

    Attributes:
        name: The name for people.
        bind_key_file: File with its key in the first line, 32 hexadecimal digits, or 24 for older Xiaomi devices.
        bind_key_env: Environment variable that holds that key.
        rssi_at_1m: How strongly it is received at a distance of one metre, in dBm.
        profile: The profile by which it is connected to; by default that of a service which it advertises.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = ""
    bind_key_file: SecretFile | None = None
    bind_key_env: SecretName | None = None
    rssi_at_1m: Annotated[float, Field(ge=-127, le=20)] | None = None
    profile: str = ""

    @model_validator(mode="after")
    def _check_key(self) -> BleDeviceSettings:
        if self.bind_key_file and self.bind_key_env:
            raise ValueError("give bind_key_file or bind_key_env, not both")
        return self

    def bind_key(self) -> bytes | None:
        """Return the key, read from where it is kept; None if it has none.

        Raises:
            UsageError: It cannot be read, or is no key; the message never shows it.
        """
        key = read_password(self.bind_key_file, self.bind_key_env, "bind_key")
        if key is None:
            return None
        setting = "bind_key_env" if self.bind_key_env is not None else "bind_key_file"
        text = key.get_secret_value()
        if not _KEY.fullmatch(text.strip()):
            raise UsageError(f"{setting}: a bind key is 32 hexadecimal digits, or 24 for an older Xiaomi device")
        return bytes.fromhex(text.strip())


class BleGatewaySettings(GatewaySettings):
    """The table ``[gateways.NAME]`` of a Bluetooth gateway.

    Attributes:
        adapter: The adapter to use, on Linux ``hci0``; by default the system's.
        scan: ``active`` asks devices for their names, which costs their batteries; ``passive`` only listens.
        listed: Which devices become known: ``understood`` are those that a parser reads or a profile is declared for;
            ``named`` also those that say a name; ``all`` every address, phones and passers-by among them.
        parsers: Which broadcasts to read, by entry-point name or ``module:Class``.
        signal: Whether the strength of the signal and the distance are reported.
        rssi_at_1m: How strongly a device is received at a distance of one metre, in dBm, that does not say it.
        forget_after: Seconds of silence after which a device is taken for gone; radio has no other farewell.
        max_devices: Devices that are known at once.
        max_connections: Devices that are connected to at once; few adapters hold more than seven.
        proxies: Receivers in other rooms: true takes those that the owner's other gateways find and that proved by a
            key or password that they are the owner's; or a list of :class:`BleProxySettings`.
        room: The room of the adapter of this computer, for the rooms that are suggested for devices.
        devices: Declared facts of single devices, by address.
        profiles: How devices that are connected to encode their state, by name.
    """

    adapter: str = ""
    scan: Literal["active", "passive"] = "active"
    listed: Listed = "understood"
    parsers: tuple[str, ...] = Field(default_factory=lambda: plugin_names(PARSERS))
    signal: bool = True
    rssi_at_1m: Annotated[float, Field(ge=-127, le=20)] = RSSI_AT_1M
    forget_after: Seconds = 7 * 86_400.0
    max_devices: Annotated[int, Field(ge=1, le=10_000)] = 500
    max_connections: Annotated[int, Field(ge=1, le=50)] = 5
    proxies: bool | tuple[BleProxySettings, ...] = False
    room: Annotated[str, Field(max_length=100)] = ""
    devices: dict[Address, BleDeviceSettings] = Field(default_factory=dict)
    profiles: dict[str, GattProfile] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check_profiles(self) -> BleGatewaySettings:
        for address, device in self.devices.items():
            if device.profile and device.profile not in self.profiles:
                names = ", ".join(self.profiles) or "none"
                raise ValueError(f"devices.{address}.profile: {device.profile!r} is unknown; known are {names}")
        return self

    @property
    def listed_proxies(self) -> tuple[BleProxySettings, ...]:
        """The proxies that the owner lists by address."""
        return self.proxies if isinstance(self.proxies, tuple) else ()

    def bind_keys(self) -> dict[str, bytes]:
        """Return the keys by address.

        Raises:
            UsageError: One cannot be read; names the device and the setting.
        """
        keys: dict[str, bytes] = {}
        for address, device in self.devices.items():
            try:
                key = device.bind_key()
            except UsageError as exc:
                raise UsageError(f'devices."{address}".{exc}') from exc
            if key is not None:
                keys[address] = key
        return keys
