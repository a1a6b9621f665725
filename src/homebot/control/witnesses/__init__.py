"""Witnesses of commands: sensors that observe their effects."""

from homebot.control.witnesses.witnesses import Witnesses

__all__ = ["Witnesses"]
