"""The table ``[gateways.mdns.drivers.esphome]``: the secrets of ESPHome devices."""

from __future__ import annotations

import binascii
from collections.abc import Mapping
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, SecretStr, model_validator

from homebot.config import FilePath, read_password
from homebot.errors import UsageError
from homebot.gateways.drivers.base import DriverSettings

__all__ = ["KEY_ADVICE", "PASSWORD_ADVICE", "PLAIN_ADVICE", "EsphomeSecrets", "EsphomeSettings"]

_KEY_BYTES = 32


class EsphomeSecrets(BaseModel):
    """The places where the secrets of one device are kept.

    Attributes:
        key_file: File whose first line is the encryption key: what the device's ESPHome configuration has under
            ``api: encryption: key:``. Relative paths begin at the folder of the configuration's file.
        key_env: Environment variable that holds it.
        password_file: Likewise for the password that old firmware wants (``api: password:``).
        password_env: Environment variable that holds it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    key_file: FilePath | None = None
    key_env: str | None = None
    password_file: FilePath | None = None
    password_env: str | None = None

    @model_validator(mode="after")
    def _check_sources(self) -> EsphomeSecrets:
        for name in ("key", "password"):
            if getattr(self, f"{name}_file") and getattr(self, f"{name}_env"):
                raise ValueError(f"give {name}_file or {name}_env, not both")
        return self

    def key(self, table: str) -> SecretStr | None:
        """Return the encryption key; None where none is named.

        Args:
            table: What stands before its keys, for errors: ``devices.hall.``

        Raises:
            UsageError: It cannot be read, or is none.
        """
        key = _read(table, "key", self.key_file, self.key_env)
        if key is not None:
            try:
                size = len(binascii.a2b_base64(key.get_secret_value(), strict_mode=True))
            except ValueError:
                size = 0
            if size != _KEY_BYTES:
                raise UsageError(f"{table}key: it is not 32 bytes in base64, as ESPHome makes them")
        return key

    def password(self, table: str) -> SecretStr | None:
        """Return the password; None where none is named.

        Raises:
            UsageError: It cannot be read.
        """
        return _read(table, "password", self.password_file, self.password_env)


class EsphomeSettings(EsphomeSecrets, DriverSettings):
    """The table of the driver; its own secrets are those of every device that has no table of its own.

    Attributes:
        devices: Secrets of single devices by their ESPHome names, such as ``kitchen-lamp``. What a device has here it
            must prove: it is not talked to without encryption.
    """

    devices: Mapping[str, EsphomeSecrets] = Field(default_factory=dict)

    def check_secrets(self) -> None:
        """Read all secrets once.

        Raises:
            UsageError: One cannot be read, or a key is none; names the key of the table.
        """
        for device in ("", *self.devices):
            self.secrets_of(device)

    def secrets_of(self, device: str) -> tuple[SecretStr | None, SecretStr | None]:
        """Return encryption key and password of a device: those of its own table, or of all where it has none.

        Raises:
            UsageError: One cannot be read, or the key is none; names the key of the table.
        """
        own = self.devices.get(device)
        secrets, table = (self, "") if own is None else (own, f"devices.{device}.")
        return secrets.key(table), secrets.password(table)


_TABLE = "gateways.mdns.drivers.esphome"

KEY_ADVICE = (
    f'put the key that its ESPHome configuration has under "api: encryption: key:" into a file, and name that in'
    f' [{_TABLE}.devices."{{0}}"] as key_file'
)
PLAIN_ADVICE = f'add "api: encryption:" to its ESPHome configuration, or remove the key in [{_TABLE}.devices."{{0}}"]'
PASSWORD_ADVICE = (
    f'put the one that its ESPHome configuration has under "api: password:" into a file, and name that in'
    f' [{_TABLE}.devices."{{0}}"] as password_file'
)
"""What to do where a device, whose name stands in for ``{0}``, does not let homebot in."""


def _read(table: str, name: str, file: Path | None, variable: str | None) -> SecretStr | None:
    try:
        return read_password(file, variable, name)
    except UsageError as exc:
        raise UsageError(f"{table}{exc}") from exc
