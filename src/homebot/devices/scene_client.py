"""Client of the scenes for applications."""

from collections.abc import Mapping
from contextlib import closing
from typing import Final, NamedTuple, final

from homebot.devices.command_messages import CommandDevicesResponse
from homebot.devices.current_trigger import current_trigger
from homebot.devices.device import target_of
from homebot.devices.names import APPLY_SCENE, LIST_SCENES
from homebot.devices.outcomes import Outcome, worst
from homebot.devices.scene_messages import ApplyScene, ApplySceneRequest, ListScenes, SceneInfo, ScenesRequest
from homebot.errors import UsageError
from homebot.graph import Node

_MAX_WAIT_S: Final = 900.0
"""Seconds after which the control layer has answered: it limits its own waiting."""


class SceneOutcome(NamedTuple):
    """The outcomes of the parts of a scene, by their ids; empty if an undo had nothing to bring back."""

    parts: Mapping[str, Outcome]

    @property
    def worst(self) -> Outcome | None:
        """The worst outcome; None without parts."""
        return worst(tuple(self.parts.values())) if self.parts else None

    @property
    def succeeded(self) -> bool:
        """True if every part is as the scene has it."""
        return all(part.succeeded for part in self.parts.values())


@final
class Scenes:
    """The scenes of the house, for the app of a node: those of the owner, and those that bridges keep.

    Its methods raise `UsageError` if there is no such scene, or the values cannot be given; the message says why.
    """

    def __init__(self, node: Node) -> None:
        self._node = node

    async def list(self) -> tuple[SceneInfo, ...]:
        """Return all scenes."""
        with closing(self._node.create_client(ListScenes, LIST_SCENES)) as client:
            answer = await client.call(ScenesRequest())
        if not answer.success:
            raise UsageError(answer.message)
        return answer.scenes

    async def apply(self, name: str, *, transition: float = 0.0) -> SceneOutcome:
        """Apply the scene with this name or id.

        Args:
            transition: Seconds that the changes take, where a device supports that.
        """
        return await self._apply(name, transition, undo=False)

    async def undo(self, name: str, *, transition: float = 0.0) -> SceneOutcome:
        """Bring back the values before the scene was applied last, where nothing else has changed them since."""
        return await self._apply(name, transition, undo=True)

    async def _apply(self, name: str, transition: float, *, undo: bool) -> SceneOutcome:
        request = ApplySceneRequest(
            name=name,
            transition=float(transition),
            undo=undo,
            issuer=self._node.full_name,
            trigger=current_trigger(),
        )
        with closing(self._node.create_client(ApplyScene, APPLY_SCENE)) as client:
            answer: CommandDevicesResponse = await client.call(request, timeout=_MAX_WAIT_S)
        if not (answer.success or answer.results):
            raise UsageError(answer.message)
        return SceneOutcome(
            {target_of(result.device, result.part): result.result.to_outcome() for result in answer.results}
        )
