"""ESPresense as a convention. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings, LazyConvention

if TYPE_CHECKING:
    from homebot.integrations.espresense.formats.reader import EspresenseReader

__all__ = ["Espresense"]


class Espresense(LazyConvention[ConventionSettings, "EspresenseReader"]):
    """Devices by the first message of a node that hears them."""

    Settings: ClassVar[type[BaseModel]] = ConventionSettings
    name: ClassVar[str] = "espresense"

    def filters(self) -> tuple[str, ...]:
        """Return the filter of heard devices."""
        return ("espresense/devices/+/+",)

    def load_reader(self) -> EspresenseReader:
        """Return a reader of heard devices."""
        from homebot.integrations.espresense.formats.reader import EspresenseReader  # noqa: PLC0415 - see LazyConvention

        return EspresenseReader()
