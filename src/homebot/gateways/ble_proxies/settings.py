"""The table ``[[gateways.NAME.proxies]]`` of a Bluetooth gateway."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, SecretStr, field_validator, model_validator

from homebot.config import PeerAddress, SecretFile, SecretName
from homebot.errors import UsageError
from homebot.gateways.password_settings import read_password
from homebot.plugins import plugin_names
from homebot.support.key_roles import KeyRole

PROXIES = "homebot.ble_proxies"
"""The plug-in group of proxies; see :class:`homebot.gateways.ble_proxies.proxy.BleProxy`."""


class BleProxySettings(BaseModel):
    """The table ``[[gateways.NAME.proxies]]``: one proxy, by its address.

    Attributes:
        kind: What it is, by entry-point name.
        address: Its IP address or host name.
        port: Its TCP port; by default that of its kind.
        key_file: File with its key or password in the first line. Relative paths begin at the folder of the
            configuration's file.
        key_env: Environment variable that holds it.
        room: The room that it is in; by default the one that it states.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    kind: str
    address: Annotated[PeerAddress, Field(min_length=1, max_length=253)]
    port: Annotated[int, Field(ge=1, le=65_535), KeyRole.PEER] | None = None
    key_file: SecretFile | None = None
    key_env: SecretName | None = None
    room: Annotated[str, Field(max_length=100)] = ""

    @field_validator("kind")
    @classmethod
    def _check_kind(cls, kind: str) -> str:
        known = plugin_names(PROXIES)
        if kind not in known and ":" not in kind:
            raise ValueError(f"{kind!r} is no kind of proxy; write one of {', '.join(known) or 'none installed'}")
        return kind

    @model_validator(mode="after")
    def _check_key(self) -> BleProxySettings:
        if self.key_file and self.key_env:
            raise ValueError("give key_file or key_env, not both")
        return self

    @property
    def place(self) -> str:
        """The address, with the port where that is given."""
        return self.address if self.port is None else f"{self.address}:{self.port}"

    def read_key(self) -> SecretStr | None:
        """Return its key, read from where it is kept; None if it has none.

        Raises:
            UsageError: It cannot be read; the message never shows it.
        """
        try:
            return read_password(self.key_file, self.key_env, "key")
        except UsageError as exc:
            raise UsageError(f'proxies."{self.address}".{exc}') from exc
