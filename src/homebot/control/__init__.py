"""Control: the one way of commands from applications to devices, which proves what became of each."""

from homebot.control.control import Control
from homebot.control.settings import ControlSettings

__all__ = ["Control", "ControlSettings"]
