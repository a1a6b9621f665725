"""OwnTracks as a convention. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import BaseModel

from homebot.conventions.convention import ConventionSettings, LazyConvention, TopicPrefix

if TYPE_CHECKING:
    from homebot.integrations.owntracks.formats.reader import OwnTracksReader

__all__ = ["OwnTracks", "OwnTracksSettings"]


class OwnTracksSettings(ConventionSettings):
    """The table of this convention.

    Attributes:
        prefix: The first level of its topics.
    """

    prefix: TopicPrefix = "owntracks"


class OwnTracks(LazyConvention[OwnTracksSettings, "OwnTracksReader"]):
    """Phones, by their first location."""

    Settings: ClassVar[type[BaseModel]] = OwnTracksSettings
    name: ClassVar[str] = "owntracks"

    def filters(self) -> tuple[str, ...]:
        """Return the filter of locations."""
        return (f"{self.settings.prefix}/+/+",)

    def problems(self) -> tuple[str, ...]:
        """Return the phones that encrypt."""
        return self.reader.problems() if self.is_loaded else ()

    def load_reader(self) -> OwnTracksReader:
        """Return a reader of locations."""
        from homebot.integrations.owntracks.formats.reader import OwnTracksReader  # noqa: PLC0415 - see LazyConvention

        return OwnTracksReader(self.settings.prefix)
