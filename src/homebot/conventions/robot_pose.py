"""Poses that robots state over MQTT in a form of their makers. Pure."""

from __future__ import annotations

from typing import Final, NamedTuple, Protocol

from homebot.places.rigid import MapPose
from homebot.plugins import load_plugin, plugin_names

_GROUP: Final = "homebot.robot_poses"


class StatedPose(NamedTuple):
    """A statement of a robot about its pose.

    Attributes:
        at: Its pose on its own map; None if it does not know it.
        limit: Seconds for which it is valid; None for the limit in the settings of the robot.
    """

    at: MapPose | None
    limit: float | None = None


class PoseReader(Protocol):
    """Reads poses in one form; the plug-in group is ``homebot.robot_poses``."""

    def read(self, payload: bytes) -> StatedPose | None:
        """Return the statement in *payload*; None if it has another form."""


def pose_readers() -> tuple[PoseReader, ...]:
    """Return the installed readers."""
    return tuple(load_plugin(_GROUP, name)() for name in plugin_names(_GROUP))
