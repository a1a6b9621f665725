"""Control: the only path for commands from applications to devices, with a verified outcome for each."""

from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.control.control import Control
    from homebot.control.settings import ControlSettings

__all__ = ["Control", "ControlSettings"]

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(
        __name__, {"homebot.control.control": "Control", "homebot.control.settings": "ControlSettings"}
    )
