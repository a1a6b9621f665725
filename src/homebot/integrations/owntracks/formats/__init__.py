"""Phones with OwnTracks."""

from homebot.integrations.owntracks.formats.convention import OwnTracks, OwnTracksSettings

__all__ = ["OwnTracks", "OwnTracksSettings"]
