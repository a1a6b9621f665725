"""The scenes of the owner, and the values before each scene that was applied. Pure."""

from collections.abc import Mapping
from typing import Any, Final, final

from pydantic import BaseModel, ConfigDict, ValidationError

from homebot.command_words.undo_record import UndoRecord
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, UsageError, WireError
from homebot.support.folding import fold
from homebot.support.printable import printable

_MAX_SCENES: Final = 300
_MAX_PARTS: Final = 10_000
_MAX_APPLIED: Final = 100
_MAX_CHARACTERS: Final = 100


class SavedScene(BaseModel):
    """A scene of the owner.

    Attributes:
        parts: Its values by capability, by the id of a device, with ``#`` and that of a part if it has one.
        routes: The routes of each part when it was saved, by which it is found after its device was merged or split.
    """

    model_config = ConfigDict(frozen=True, extra="ignore", defer_build=True)

    name: str
    parts: Mapping[str, Mapping[str, PlainValue]]
    routes: Mapping[str, tuple[str, ...]] = {}


class AppliedScene(BaseModel):
    """The facts for an undo of a scene.

    Attributes:
        at: When it was applied, in seconds since the Unix epoch.
        before: See :class:`homebot.command_words.undo_record.UndoRecord`.
        is_undone: Whether it was undone since.
    """

    model_config = ConfigDict(extra="ignore", defer_build=True)

    at: float
    before: dict[str, list[Any]] = {}
    is_undone: bool = False


class _BookRecord(BaseModel):
    model_config = ConfigDict(extra="ignore", defer_build=True)

    scenes: tuple[SavedScene, ...] = ()
    applied: dict[str, AppliedScene] = {}


@final
class SceneBook:
    """The scenes of the owner by folded name, and the applied ones by id.

    Args:
        record: The text that :meth:`record` returned; empty for none.

    Raises:
        WireError: It cannot be read.
    """

    def __init__(self, record: str = "") -> None:
        try:
            read = _BookRecord.model_validate_json(record) if record else _BookRecord()
        except ValidationError as exc:
            raise WireError(f"no scenes: {exc.errors()[0]['msg']}", record[:100].encode(errors="replace")) from exc
        self.scenes = {fold(scene.name): scene for scene in read.scenes}
        self.applied = read.applied

    def record(self) -> str:
        """Return everything as text."""
        return _BookRecord(scenes=tuple(self.scenes.values()), applied=self.applied).model_dump_json()

    def put(self, scene: SavedScene) -> None:
        """Add a scene, in place of one of the same name.

        Raises:
            UsageError: Its name cannot be one.
            RefusedError: There are too many.
        """
        name = scene.name
        check_scene_name(name)
        others = [other for key, other in self.scenes.items() if key != fold(name)]
        if len(others) >= _MAX_SCENES or sum(len(kept.parts) for kept in (scene, *others)) > _MAX_PARTS:
            limits = f"there may be {_MAX_SCENES} with {_MAX_PARTS:,} parts in all; remove one first"
            raise RefusedError(f"the scene {name!r}", limits)
        self.scenes[fold(name)] = scene

    def rename(self, known: SavedScene, name: str) -> SavedScene:
        """Give a scene another name; raise as :meth:`put`, or UsageError if another scene has it."""
        if fold(name) != fold(known.name) and fold(name) in self.scenes:
            raise UsageError(f"there is a scene {name!r} already")
        del self.scenes[fold(known.name)]
        scene = known.model_copy(update={"name": name})
        try:
            self.put(scene)
        except BaseException:
            self.scenes[fold(known.name)] = known
            raise
        if (applied := self.applied.pop(known.name, None)) is not None:
            self.applied[name] = applied
        return scene

    def remove(self, name: str) -> None:
        """Forget the scene with this folded name."""
        self.applied.pop(self.scenes.pop(name).name, None)

    def begin(self, scene_id: str, at: float) -> UndoRecord:
        """Return the values before the scene with this id, for those before another time."""
        applied = self.applied.pop(scene_id, None) or AppliedScene(at=at)
        applied.at, applied.is_undone = at, False
        self.applied[scene_id] = applied
        while len(self.applied) > _MAX_APPLIED:
            del self.applied[next(iter(self.applied))]
        return UndoRecord(applied.before)


def check_scene_name(name: str) -> None:
    """Raise UsageError if *name* cannot name a scene."""
    if not fold(name) or name != name.strip() or printable(name, _MAX_CHARACTERS) != name:
        raise UsageError(
            f"{name[:_MAX_CHARACTERS]!r} cannot name a scene: give 1 to {_MAX_CHARACTERS} printable characters"
        )
