"""The table ``[gateways.mdns.drivers.shelly]``."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field, SecretStr

from homebot.gateways.drivers.base import DriverSettings
from homebot.gateways.password_settings import PasswordSettings

__all__ = ["ShellyDriverSettings", "wants_password"]


class ShellyDriverSettings(PasswordSettings, DriverSettings):
    """The passwords of Shelly's devices; the user is always ``admin``. Its own is for all that have no other.

    Attributes:
        devices: Passwords of single devices, by the id that is printed on each: ``shellyplus1-a8032abe54dc``.
    """

    devices: Mapping[str, PasswordSettings] = Field(default_factory=dict)

    def check_secrets(self) -> None:
        """Read all passwords once."""
        self.read_password()
        for device_id in self.devices:
            self.password_of(device_id)

    def password_of(self, device_id: str) -> SecretStr | None:
        """Return the password of a device; None if it has none.

        Raises:
            UsageError: It cannot be read; names the key.
        """
        for name, own in self.devices.items():
            if name.casefold() == device_id.casefold():
                return own.read_password(f"devices.{name}.")
        return self.read_password()


def wants_password(*, has_one: bool) -> str:
    """Return the remedy if a device asks for a password, as text."""
    keys = "password_file or password_env in [gateways.mdns.drivers.shelly]"
    return f"it refuses the password given by {keys}" if has_one else f"it wants a password; give {keys}"
