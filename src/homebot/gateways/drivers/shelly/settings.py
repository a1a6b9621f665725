"""The table ``[gateways.mdns.drivers.shelly]``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Self

from pydantic import BaseModel, ConfigDict, Field, SecretStr, model_validator

from homebot.config import FilePath, read_password
from homebot.errors import UsageError
from homebot.gateways.drivers.base import DriverSettings

__all__ = ["ShellyDriverSettings", "ShellyPasswordSettings"]


class ShellyPasswordSettings(BaseModel):
    """The password of one device.

    Attributes:
        password_file: File whose first line is the password, for nobody else to read. Relative paths begin at the
            folder of the configuration's file.
        password_env: Environment variable that holds the password.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    password_file: FilePath | None = None
    password_env: str | None = None

    @model_validator(mode="after")
    def _check_password(self) -> Self:
        _check_one(self.password_file, self.password_env)
        return self


class ShellyDriverSettings(DriverSettings):
    """The passwords of Shelly's devices; the user is always ``admin``.

    Attributes:
        password_file: The same as in :class:`ShellyPasswordSettings`, for all devices that have none of their own.
        password_env: Likewise.
        devices: Passwords of single devices, by the id that is printed on each: ``shellyplus1-a8032abe54dc``.
    """

    password_file: FilePath | None = None
    password_env: str | None = None
    devices: Mapping[str, ShellyPasswordSettings] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check_password(self) -> Self:
        _check_one(self.password_file, self.password_env)
        return self

    def read_passwords(self) -> None:
        """See whether all passwords can be read.

        Raises:
            UsageError: One cannot; names the key.
        """
        read_password(self.password_file, self.password_env)
        for device_id in self.devices:
            self.password_of(device_id)

    def password_of(self, device_id: str) -> SecretStr | None:
        """Return the password of a device; None where it has none.

        Raises:
            UsageError: It cannot be read; names the key.
        """
        for name, own in self.devices.items():
            if name.casefold() == device_id.casefold():
                try:
                    return read_password(own.password_file, own.password_env)
                except UsageError as exc:
                    raise UsageError(f"devices.{name}.{exc}") from exc
        return read_password(self.password_file, self.password_env)


def _check_one(password_file: Path | None, password_env: str | None) -> None:
    if password_file and password_env:
        raise ValueError("give password_file or password_env, not both")
