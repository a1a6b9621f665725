"""Simulated NFC tags, and the field of a simulated reader that they are held into."""

from homebot.house.nfc.field import ServedTag, TagField
from homebot.house.nfc.type4_card import Type4Card

__all__ = ["ServedTag", "TagField", "Type4Card"]
