"""The pose in a ``state`` or ``visualization``, for a robot of the house that names its topic. Pure."""

from typing import Final

from homebot.conventions.payload import as_fields, to_json
from homebot.conventions.robot_pose import StatedPose
from homebot.integrations.vda5050.formats.state import position_of

_AT_REST: Final = 35.0
"""Seconds; a robot at rest repeats its state after 30."""


class Vda5050Poses:
    """The reader of poses; see :class:`homebot.conventions.robot_pose.PoseReader`."""

    def read(self, payload: bytes) -> StatedPose | None:
        """Return the pose; None for another message."""
        message = as_fields(to_json(payload))
        if not ("serialNumber" in message and "headerId" in message):
            return None
        return StatedPose(position_of(message)[0], _AT_REST if message.get("driving") is False else None)
