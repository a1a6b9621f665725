"""Requesters of doors and lifts, whose holds end with their connections, or with those of their robots."""

from typing import Final, final

from homebot.devices.names import WHERE_IS_ROBOT
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.errors import ServiceError
from homebot.graph import GraphEntity, Node
from homebot.support.folding import fold

UNKNOWN: Final = "requesters.unknown"
_WITHIN_S: Final = 5.0


@final
class Requesters:
    """The requesters of *node*, such as ``FLEET/ROBOT`` of Open-RMF."""

    def __init__(self, node: Node) -> None:
        self._log = node.log
        self._where = node.create_client(WhereIsRobot, WHERE_IS_ROBOT)

    async def is_gone(self, requester: str, sender: GraphEntity | None) -> bool:
        """Return whether the *sender* of the last request is closed, or the robot called *requester* is gone.

        A robot that the house does not know is not gone, nor one whose tracker does not answer.
        """
        if sender is not None and sender.is_closed:
            return True
        if not self._where.service_is_ready():
            return False
        robot = requester.rpartition("/")[2]
        try:
            answer = await self._where.call(WhereIsRobotRequest(robot=robot), timeout=_WITHIN_S)
        except ServiceError as exc:
            self._log.warning(UNKNOWN, message=f"whether {requester} is gone is unknown: {exc}")
            return False
        return answer.is_gone and fold(answer.robot) == fold(robot)
