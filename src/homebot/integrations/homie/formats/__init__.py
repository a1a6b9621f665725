"""The Homie convention, versions 3, 4 and 5."""

from homebot.integrations.homie.formats.convention import Homie, HomieSettings

__all__ = ["Homie", "HomieSettings"]
