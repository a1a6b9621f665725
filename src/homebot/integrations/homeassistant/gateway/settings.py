"""The table ``[gateways.NAME]`` of a Home Assistant gateway."""

from typing import Annotated, Final, Self
from urllib.parse import urlsplit

from pydantic import Field, field_validator, model_validator

from homebot.config import PeerAddress, SecretFile, SecretName
from homebot.gateways.base import GatewaySettings
from homebot.gateways.password_settings import read_password

HOW_TO_LOG_IN: Final = (
    "make a token in Home Assistant (your profile, Security, Long-lived access tokens) and put it into a file that "
    "only you can read, named by token_file"
)


class HomeAssistantGatewaySettings(GatewaySettings):
    """The settings of a Home Assistant gateway.

    Attributes:
        url: The address of Home Assistant, as in a browser.
        token_file: File with a long-lived access token in its first line, readable by its owner only. Relative paths
            begin at the folder of the configuration's file. It is read again for each connection.
        token_env: Environment variable that holds the token.
        max_entities: Most known entities; further ones are left out and counted.
    """

    url: PeerAddress = "http://homeassistant.local:8123"
    token_file: SecretFile | None = None
    token_env: SecretName | None = None
    max_entities: Annotated[int, Field(ge=1, le=50_000)] = 10_000

    @field_validator("url")
    @classmethod
    def _check_url(cls, url: str) -> str:
        address = urlsplit(url)  # raises ValueError itself
        if address.scheme not in {"ws", "wss", "http", "https"} or not address.hostname:
            raise ValueError("the address of Home Assistant is written like http://homeassistant.local:8123")
        if address.username is not None or address.password is not None:
            raise ValueError("Home Assistant takes a token, not a user and a password; leave them out")
        return url.rstrip("/")

    @model_validator(mode="after")
    def _check_one_source(self) -> Self:
        if (self.token_file is None) is (self.token_env is None):
            raise ValueError(f"give token_file or token_env, and not both; {HOW_TO_LOG_IN}")
        return self

    def read_token(self) -> str:
        """Return the token.

        Raises:
            UsageError: It cannot be read; the message names the key.
        """
        token = read_password(self.token_file, self.token_env, "token")
        return "" if token is None else token.get_secret_value()

    @property
    def remedy(self) -> str:
        """The steps to a valid token."""
        then = "and restart homebot" if self.token_env else "which is read again within five minutes"
        place = self.token_env or self.token_file
        return (
            f"make a new one (your profile there, Security, Long-lived access tokens) and put it into {place}, {then}"
        )

    @property
    def websocket(self) -> str:
        """The address of its WebSocket."""
        address = self.url.replace("http", "ws", 1) if self.url.startswith("http") else self.url
        return address if address.endswith("/api/websocket") else f"{address}/api/websocket"
