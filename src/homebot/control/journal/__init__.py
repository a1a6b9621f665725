"""The journal: each step of each command, and changes of devices that no command explains, as data."""

from homebot.control.journal.journal import CommandJournal

__all__ = ["CommandJournal"]
