"""The table ``[gateways.mdns.drivers.esphome]``: the secrets of ESPHome devices."""

from __future__ import annotations

import binascii
from collections.abc import Mapping
from ipaddress import ip_address

from pydantic import Field, SecretStr, field_validator, model_validator

from homebot.config import PeerAddress, SecretFile, SecretName
from homebot.errors import RefusedError, UsageError
from homebot.gateways.drivers.base import DriverSettings
from homebot.gateways.password_settings import PasswordSettings, read_password

_KEY_BYTES = 32
_TABLE = "gateways.mdns.drivers.esphome"

PLAINTEXT_ADVICE = (
    'a password alone would be sent unencrypted to whoever announces the device: add "api: encryption:" to its ESPHome '
    f"configuration and give its key_file, or its fixed IP address as allow_plaintext_at in [{_TABLE}.devices.NAME]"
)
"""The remedy if a device has a password and no encryption key."""


class EsphomeSecrets(PasswordSettings):
    """The places of the secrets of one device.

    The password is required by old firmware (``api: password:``). It needs a key, or *allow_plaintext_at*: without
    encryption, any host that announces the device would be sent the password.

    Attributes:
        key_file: File with the encryption key in its first line, as in the device's ESPHome configuration under
            ``api: encryption: key:``. Relative paths begin at the folder of the configuration's file.
        key_env: Environment variable that holds it.
        allow_plaintext_at: IP address at which one device without encryption is sent its password, and at no other.
            Give the device a fixed address, and no computer that you do not trust access to its network.
    """

    key_file: SecretFile | None = None
    key_env: SecretName | None = None
    allow_plaintext_at: PeerAddress | None = None

    @field_validator("allow_plaintext_at")
    @classmethod
    def _check_address(cls, address: str | None) -> str | None:
        try:
            return None if address is None else str(ip_address(address))
        except ValueError:
            raise ValueError("it is not an IP address; names can be announced by anybody on the network") from None

    @model_validator(mode="after")
    def _check_sources(self) -> EsphomeSecrets:
        if self.key_file and self.key_env:
            raise ValueError("give key_file or key_env, not both")
        has_key = bool(self.key_file or self.key_env)
        if has_key and self.allow_plaintext_at:
            raise ValueError("a device with a key is only connected to with encryption; remove allow_plaintext_at")
        if (self.password_file or self.password_env) and not (has_key or self.allow_plaintext_at):
            raise ValueError(PLAINTEXT_ADVICE)
        return self

    def read_key(self, table: str) -> SecretStr | None:
        """Return the encryption key; None if none is named.

        Args:
            table: The prefix of its keys, for errors: ``devices.hall.``

        Raises:
            UsageError: It cannot be read, or is none.
        """
        return checked_key(read_password(self.key_file, self.key_env, f"{table}key"), table)


def checked_key(key: SecretStr | None, table: str) -> SecretStr | None:
    """Return an encryption key.

    Raises:
        UsageError: It is none; names the key of the *table*.
    """
    if key is not None:
        try:
            size = len(binascii.a2b_base64(key.get_secret_value(), strict_mode=True))
        except ValueError:
            size = 0
        if size != _KEY_BYTES:
            raise UsageError(f"{table}key: it is not 32 bytes in base64, as ESPHome makes them")
    return key


class EsphomeSettings(EsphomeSecrets, DriverSettings):
    """The table of the driver. Its own secrets are used for every device that has no table of its own.

    Attributes:
        devices: Secrets of single devices by their ESPHome names, such as ``kitchen-lamp``. A device that has a key
            here is never connected to without encryption.
    """

    devices: Mapping[str, EsphomeSecrets] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _check_address_of_all(self) -> EsphomeSettings:
        if self.allow_plaintext_at:
            raise ValueError(f"allow_plaintext_at belongs to one device, in [{_TABLE}.devices.NAME]")
        return self

    def check_secrets(self) -> None:
        """Read all secrets once."""
        for device in ("", *self.devices):
            self.secrets_of(device)

    def secrets_of(self, device: str) -> tuple[SecretStr | None, SecretStr | None]:
        """Return encryption key and password of a device: those of its own table, or of all where it has none.

        Raises:
            UsageError: One cannot be read, or the key is none; names the key of the table.
        """
        own = self.devices.get(device)
        secrets, table = (self, "") if own is None else (own, f"devices.{device}.")
        return secrets.read_key(table), secrets.read_password(table)

    def addresses_of(self, device: str, announced: tuple[str, ...]) -> tuple[str, ...]:
        """Return those of *announced* at which a device may be connected to: all, unless its table names one.

        Raises:
            RefusedError: None of them is the one in its table; the message gives the remedy.
        """
        own = self.devices.get(device)
        if own is None or own.allow_plaintext_at is None:
            return announced
        if own.allow_plaintext_at not in announced:
            why = f"it is announced at {announced[0] if announced else 'no address'}, and its allow_plaintext_at is"
            raise RefusedError(f"the connection to {device}", f"{why} {own.allow_plaintext_at}; {PLAINTEXT_ADVICE}")
        return (own.allow_plaintext_at,)


KEY_ADVICE = (
    f'put the key that its ESPHome configuration has under "api: encryption: key:" into a file, and name that in'
    f' [{_TABLE}.devices."{{0}}"] as key_file'
)
PLAIN_ADVICE = f'add "api: encryption:" to its ESPHome configuration, or remove the key in [{_TABLE}.devices."{{0}}"]'
PASSWORD_ADVICE = (
    f'put the one that its ESPHome configuration has under "api: password:" into a file, and name that in'
    f' [{_TABLE}.devices."{{0}}"] as password_file'
)
"""The remedy if a device refuses homebot; ``{0}`` stands for its name."""
