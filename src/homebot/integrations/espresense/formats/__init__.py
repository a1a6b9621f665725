"""Phones and tags that nodes of ESPresense hear."""

from homebot.integrations.espresense.formats.convention import Espresense

__all__ = ["Espresense"]
