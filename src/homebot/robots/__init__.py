"""Robots of the house: where each of them is, from all that is known of it."""

from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.robots.settings import RobotSettings
    from homebot.robots.tracker import RobotTracker

__all__ = ["RobotSettings", "RobotTracker"]

if not TYPE_CHECKING:  # else a name that does not exist would pass for one
    __getattr__ = lazy_names(
        __name__, {"homebot.robots.settings": "RobotSettings", "homebot.robots.tracker": "RobotTracker"}
    )
