"""Profiles of all devices, saved over a restart: one record for each part."""

from __future__ import annotations

from collections import OrderedDict, deque
from typing import Annotated, Final, Literal, TypeAlias, final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from homebot.control.learnt import SaveRecord
from homebot.control.timeline.profile import KEPT, KEPT_ANSWERS, DeviceProfile, Return
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = ["PROFILE", "Profiles"]

PROFILE: Final = "profile"
"""The kind of the records."""

_MOST: Final = 10_000

_Seconds: TypeAlias = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_Times: TypeAlias = Annotated[tuple[_Seconds, ...], Field(max_length=KEPT)]
_Returns: TypeAlias = Annotated[tuple[tuple[bool, _Seconds | None], ...], Field(max_length=KEPT)]
_Echoes: TypeAlias = Annotated[tuple[bool, ...], Field(max_length=KEPT)]
_Value: TypeAlias = bool | float | str | tuple[float, ...] | None
_Answers: TypeAlias = Annotated[tuple[tuple[_Value, _Value], ...], Field(max_length=KEPT_ANSWERS)]


class _SavedProfile(BaseModel):
    """Record of a profile; fields of later versions are ignored."""

    model_config = ConfigDict(extra="ignore", defer_build=True)

    version: Literal[1] = 1
    target: str
    times: dict[str, _Times] = Field(default_factory=dict)
    returns: dict[str, _Returns] = Field(default_factory=dict)
    echoes: dict[str, _Echoes] = Field(default_factory=dict)
    answers: dict[str, _Answers] = Field(default_factory=dict)
    failures: Annotated[dict[str, int], Field(max_length=KEPT)] = Field(default_factory=dict)
    is_told_once: bool = False


@final
class Profiles:
    """The profiles of the last 10,000 commanded parts; the longest unused is forgotten."""

    def __init__(self, save: SaveRecord) -> None:
        self._save = save
        self._known: OrderedDict[str, DeviceProfile] = OrderedDict()

    def of(self, target: str) -> DeviceProfile:
        """Return the profile of a part; a new one if it is not known."""
        profile = self._known.get(target)
        if profile is None:
            profile = self._known[target] = DeviceProfile()
            if len(self._known) > _MOST:
                forgotten, _ = self._known.popitem(last=False)
                self._save(forgotten, "")
        else:
            self._known.move_to_end(target)
        return profile

    def save(self, target: str, profile: DeviceProfile) -> None:
        """Save a profile if it was changed."""
        if not profile.is_changed:
            return
        profile.is_changed = False
        record = _SavedProfile.model_construct(
            target=target,
            times={name: tuple(times) for name, times in profile.times.items()},
            returns={name: tuple((one.is_fast, one.after) for one in known) for name, known in profile.returns.items()},
            echoes={name: tuple(known) for name, known in profile.echoes.items()},
            answers={name: tuple(known.items()) for name, known in profile.answers.items()},
            failures=dict(profile.failures),
            is_told_once=profile.is_told_once,
        )
        self._save(target, record.model_dump_json(exclude_defaults=True))

    def restore(self, name: str, record: str) -> None:
        """Restore a profile of an earlier run.

        Raises:
            WireError: It cannot be read, or is of another version.
        """
        saved, profile = _read(name, record), self.of(name)
        for capability, times in saved.times.items():
            profile.times.setdefault(capability, deque(times, maxlen=KEPT))
        for capability, returns in saved.returns.items():
            profile.returns.setdefault(capability, deque((Return(*one) for one in returns), maxlen=KEPT))
        for capability, echoes in saved.echoes.items():
            profile.echoes.setdefault(capability, deque(echoes, maxlen=KEPT))
        for capability, answers in saved.answers.items():
            known: OrderedDict[PlainValue, PlainValue] = OrderedDict(answers)
            profile.answers.setdefault(capability, known)
        profile.failures = {**saved.failures, **profile.failures}
        profile.is_told_once = profile.is_told_once or saved.is_told_once


def _read(name: str, record: str) -> _SavedProfile:
    try:
        saved = _SavedProfile.model_validate_json(record)
    except ValidationError as exc:
        raise WireError(f"it is no profile of a device: {exc.errors()[0]['msg']}", record.encode()) from exc
    if name != saved.target:
        raise WireError("its name is that of another", record.encode())
    return saved
