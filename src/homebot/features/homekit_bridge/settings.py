"""The table ``[homekit_bridge]``."""

from typing import Annotated, Final, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from homebot.config import Config, parse_settings, value_errors
from homebot.plugins import check_extra
from homebot.support.addresses import is_loopback
from homebot.words.exact_queries import parse_exact_query

_MAX_QUERIES: Final = 100
_Texts = Annotated[tuple[str, ...], Field(max_length=_MAX_QUERIES)]


class HomekitBridgeSettings(BaseModel):
    """The keys of ``[homekit_bridge]``.

    Attributes:
        export: The devices that Apple Home has, as queries; what always asks, such as a lock, only by its name or id.
        exclude: Those that it has not.
        scenes: The scenes of the owner that are switches there; ``true`` for all.
        routines: The routines that are switches there.
        name: The name of the bridge; by default that of the home.
        address: The address on which it listens, and which others on the network see.
        port: Its port; a second bridge has the next one. 0 for any.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    export: _Texts = ()
    exclude: _Texts = ()
    scenes: bool | _Texts = False
    routines: _Texts = ()
    name: str = Field(default="", max_length=40)
    address: str = "127.0.0.1"
    port: int = Field(default=21_064, ge=0, le=65_000)

    @model_validator(mode="after")
    def _check_queries(self) -> Self:
        with value_errors():
            for text in (*self.export, *self.exclude):
                parse_exact_query(text)
        return self

    @property
    def is_announced(self) -> bool:
        """True if others on the network can reach it."""
        return not is_loopback(self.address)


def read_homekit_bridge(config: Config) -> HomekitBridgeSettings:
    """Return the table ``[homekit_bridge]``.

    Raises:
        ConfigError: It is wrong.
        UsageError: HAP-python is missing.
    """
    table = config.features["homekit_bridge"]
    check_extra("[homekit_bridge]", "homekit", "pyhap")
    return parse_settings(HomekitBridgeSettings, table, config.source, "homekit_bridge", config.folder)
