"""What tests of homebot, and of programs made with it, need."""

from homebot.testing.virtual_time import VirtualTimeLoop

__all__ = ["VirtualTimeLoop"]
