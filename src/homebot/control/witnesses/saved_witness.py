"""Knowledge of one sensor as a witness, as a line of the journal's store, and back. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Final, TypeAlias

from pydantic import Field

from homebot.control.learnt_record import LearntRecord
from homebot.control.witnesses.effect import Effect
from homebot.control.witnesses.sensor_resolution import Step
from homebot.control.witnesses.witness_record import MOST_OBSERVATIONS, Observation

__all__ = ["SavedWitness", "read_witness", "witness_name", "witness_record"]

_MOST_STEPS: Final = 64
_MOST_LEVELS: Final = 16
_LONGEST: Final = 1000

_Number: TypeAlias = Annotated[float, Field(allow_inf_nan=False)]
_Positive: TypeAlias = Annotated[float, Field(ge=0, allow_inf_nan=False)]
_Text: TypeAlias = Annotated[str, Field(max_length=_LONGEST)]
_Place: TypeAlias = tuple[str, str, str]


@dataclass(frozen=True, slots=True)
class SavedWitness:
    """Knowledge of one sensor as a witness of one part.

    Attributes:
        target: The part.
        sensor: The ids of the sensor's device and part, and its capability.
        observations: What it did at commands to the part, oldest first.
        seen_in_row: How many effects it saw in a row.
        steps: The changes that show how finely it reports, with times in seconds since the Unix epoch.
        levels: Its last readings, oldest first.
    """

    target: str
    sensor: _Place
    observations: tuple[Observation, ...]
    seen_in_row: int
    steps: tuple[Step, ...]
    levels: tuple[float, ...]


class _KeptWitness(LearntRecord):
    title = "witness that was learnt"

    target: str
    sensor: _Place
    observations: Annotated[
        tuple[tuple[bool, _Positive, _Text, _Number, _Positive, _Positive, _Positive, bool], ...],
        Field(max_length=MOST_OBSERVATIONS),
    ]
    seen_in_row: Annotated[int, Field(ge=0)]
    steps: Annotated[tuple[tuple[_Number, _Number, _Positive], ...], Field(max_length=_MOST_STEPS)]
    levels: Annotated[tuple[_Number, ...], Field(max_length=_MOST_LEVELS)]

    @property
    def kept_as(self) -> str:
        return witness_name(self.target, self.sensor)


def witness_name(target: str, sensor: _Place) -> str:
    """Return the name of what is known of *sensor* as a witness of *target*."""
    device, part, capability = sensor
    return f"{target} by {device}#{part} {capability}"


def witness_record(known: SavedWitness) -> str:
    """Return *known* as text; of more than 64 steps the newest."""
    observations = tuple(
        (
            one.effect.rises,
            one.effect.size,
            one.effect.looks,
            one.before,
            one.change,
            one.delay,
            one.swing,
            one.fell_silent,
        )
        for one in known.observations
    )
    return _KeptWitness(
        target=known.target,
        sensor=known.sensor,
        observations=observations,
        seen_in_row=known.seen_in_row,
        steps=known.steps[-_MOST_STEPS:],
        levels=known.levels[-_MOST_LEVELS:],
    ).model_dump_json()


def read_witness(name: str, record: str) -> SavedWitness:
    """Return what :func:`witness_record` made the text of.

    Raises:
        WireError: It is no such text, of another version, or of other sensors than *name*.
    """
    row = _KeptWitness.read(name, record)
    observations = tuple(
        Observation(Effect(rises, size, looks), before, change, delay, swing, fell_silent)
        for rises, size, looks, before, change, delay, swing, fell_silent in row.observations
    )
    return SavedWitness(row.target, row.sensor, observations, row.seen_in_row, row.steps, row.levels)
