"""Questions for the scenes that nodes keep: no attribute tells them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

from homebot.errors import LinkError, PeerError
from homebot.integrations.matter.formats.endpoint import ClusterInvocation, MatterEndpoint, MatterScene
from homebot.integrations.matter.formats.scenes import (
    SCENES,
    groups_at,
    read_scene,
    scene_count,
    scene_numbers,
    scenes_of,
)
from homebot.integrations.matter.gateway.server_link import check_result

if TYPE_CHECKING:
    from collections.abc import Callable

    from homebot.gateways.linked_gateway import LinkedGateway
    from homebot.integrations.matter.gateway.node import MatterNode
    from homebot.integrations.matter.gateway.server_link import MatterServerLink

_NONE: Final = (0, ())


@final
class SceneReader:
    """Asks the endpoints of which the number of scenes has changed, one after the other.

    Args:
        on_scenes: Takes a node with new scenes.

    Attributes:
        link: The link to the server; to be set before a node is looked at.
    """

    link: MatterServerLink

    def __init__(self, gateway: LinkedGateway, on_scenes: Callable[[MatterNode], None]) -> None:
        self._gateway, self._on_scenes = gateway, on_scenes
        self._known: dict[int, dict[int, tuple[int, tuple[MatterScene, ...]]]] = {}
        self._due: dict[int, MatterNode] = {}

    def look_at(self, node: MatterNode) -> None:
        """Give the endpoints of *node* the scenes that are known, and have those with other ones asked."""
        self._assign_scenes(node)
        if node.is_available and any(self._is_due(node, endpoint) for endpoint in node.endpoints.values()):
            if not self._due:
                self._gateway.node.create_task(self._run)
            self._due[node.id] = node

    def forget(self, node_id: int) -> None:
        """Forget a node."""
        self._known.pop(node_id, None)

    def _assign_scenes(self, node: MatterNode) -> None:
        known = self._known.get(node.id, {})
        for endpoint in node.endpoints.values():
            endpoint.scenes = known.get(endpoint.id, _NONE)[1]

    def _is_due(self, node: MatterNode, endpoint: MatterEndpoint) -> bool:
        return self._known.get(node.id, {}).get(endpoint.id, _NONE)[0] != scene_count(endpoint)

    async def _run(self) -> None:
        while self._due:
            node = self._due[next(iter(self._due))]
            for endpoint in [endpoint for endpoint in node.endpoints.values() if self._is_due(node, endpoint)]:
                await self._read(node, endpoint)
            if self._due[node.id] is node:
                del self._due[node.id]
                self._assign_scenes(node)
                self._on_scenes(node)

    async def _read(self, node: MatterNode, endpoint: MatterEndpoint) -> None:
        count, root, scenes = scene_count(endpoint), node.endpoints.get(0) or MatterEndpoint(0), list[MatterScene]()
        try:
            for group in groups_at(root, endpoint) if count else ():
                for number in scene_numbers(await self._ask(node, endpoint, scenes_of(group))):
                    payload = {"groupID": group, "sceneID": number}
                    answer = await self._ask(node, endpoint, ClusterInvocation(SCENES, "ViewScene", payload))
                    scenes.append(read_scene(group, number, answer))
        except LinkError:
            return  # it is asked when it is reached again
        except PeerError as exc:
            self._gateway.on_invalid(b"", f"the scenes of node {node.id} cannot be read: {exc}")
        self._known.setdefault(node.id, {})[endpoint.id] = count, tuple(scenes)

    async def _ask(self, node: MatterNode, endpoint: MatterEndpoint, question: ClusterInvocation) -> object:
        name, args = question.server_call(node.id, endpoint.id)
        answer = await self.link.call("the scenes", name, args)
        check_result("the scenes", answer)
        return answer
