"""Tells the directory where the devices are that tags point to: a tag at a device knows the room."""

from __future__ import annotations

from typing import Final, final

from homebot.devices.names import TEACH_PLACE
from homebot.devices.places_messages import TeachPlace, TeachPlaceRequest
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.log import LogLimit

__all__ = ["PlaceTeacher"]

TAUGHT: Final = "nfc.place_taught"
NOT_TAUGHT: Final = "nfc.place_not_taught"


@final
class PlaceTeacher:
    """Teaches rooms."""

    def __init__(self, node: Node) -> None:
        self._node = node
        self._client = node.create_client(TeachPlace, TEACH_PLACE)
        self._limit = LogLimit(node.graph.clock)

    async def teach(self, tag: str, device: str, room: str) -> None:
        """Report that the tag *tag* points to *device*, and is in *room*, which is empty if the tag says none."""
        request = TeachPlaceRequest(device=device, gateway=self._node.name, tag=tag, room=room)
        try:
            answer = await self._client.call(request)
        except ServiceError as exc:
            self._note_failure(tag, device, str(exc))
            return
        if answer.success and answer.is_new:
            text = f"the tag {tag} says where {device} is, which is in {answer.room} now"
            self._node.log.info(TAUGHT, message=text, device=device, tag=tag)
        elif not answer.success and room:
            self._note_failure(tag, device, answer.message)

    def _note_failure(self, tag: str, device: str, why: str) -> None:
        held_back = self._limit.allows(NOT_TAUGHT)
        if held_back is not None:
            text = f"the tag {tag} teaches no room of {device}: {why}"
            self._node.log.warning(NOT_TAUGHT, message=text, device=device, tag=tag, held_back=held_back)
