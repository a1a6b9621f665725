"""The pose in a ``state`` or ``visualization``, for a robot of the house that names its topic. Pure."""

from typing import Final

from homebot.conventions.payload import as_fields, to_json
from homebot.conventions.robot_pose import StatedPose
from homebot.integrations.vda5050.formats.state import MessageHeader, header_of, position_of

_AT_REST: Final = 35.0
"""Seconds; a robot at rest repeats its state after 30."""


class Vda5050Poses:
    """The reader of poses of one robot; see :class:`homebot.conventions.robot_pose.PoseReader`."""

    def __init__(self) -> None:
        self._last: tuple[MessageHeader, StatedPose] | None = None

    def read(self, payload: bytes) -> StatedPose | None:
        """Return the pose, of a message that comes late that of the newer one; None for another message."""
        message = as_fields(to_json(payload))
        if not ("serialNumber" in message and "headerId" in message):
            return None
        header = header_of(message)
        if self._last is None or not header.is_late(self._last[0]):
            limit = _AT_REST if message.get("driving") is False else None
            self._last = header, StatedPose(position_of(message)[0], limit)
        return self._last[1]
