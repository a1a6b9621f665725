"""The journal: each step of each command, and changes of devices that no command explains, as data."""

from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.control.journal.journal import CommandJournal

__all__ = ["CommandJournal"]

if not TYPE_CHECKING:  # else a name that does not exist would pass for one
    __getattr__ = lazy_names(__name__, {"homebot.control.journal.journal": "CommandJournal"})
