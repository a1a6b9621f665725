"""Rows of tables: a capability of an entity, service, cluster or resource, with its reader and writer. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

from homebot.conventions.payload import shown
from homebot.devices.part import Capability, CodeKind
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

SourceT = TypeVar("SourceT")
ReadT = TypeVar("ReadT", bound=Callable[..., PlainValue])
WriteT = TypeVar("WriteT", bound=Callable[..., object])
ToldT = TypeVar("ToldT")


@dataclass(frozen=True)
class CapabilityRow(Generic[SourceT, ReadT, WriteT]):
    """A capability of a source: an entity, a service, a cluster, a resource; each column may be a function of it.

    Attributes:
        named: Returns its name, in place of *capability*, if the source decides on it.
        read: Returns its value, None for unknown; never raises. None if it is never reported, or only by events.
        write: Returns the values that a command sets; raises RefusedError. None if it cannot be set.
        when: Whether a source has it; None if all have.
        readable: Whether it is reported; by default if it is read, or cannot be set.
        settable: Whether it can be set, if it has a *write*.
        watched: The names or numbers, in the protocol, that its value depends on.
        part: The part with it beside the main one of the source, such as ``battery``; empty for the main one.
        spare_part: The part with it if another row gives the main part its capability; empty for none.
    """

    capability: str
    read: ReadT | None = None
    write: WriteT | None = None
    when: Callable[[SourceT], object] | None = None
    options: tuple[str, ...] | Callable[[SourceT], tuple[str, ...]] = ()
    bounds: tuple[float, ...] | Callable[[SourceT], tuple[float, ...]] = ()
    unit: str | Callable[[SourceT], str] = ""
    grid: tuple[float, ...] | Callable[[SourceT], tuple[float, ...]] = ()
    readable: Callable[[SourceT], bool] | None = None
    settable: bool | Callable[[SourceT], bool] = True
    watched: tuple[str | int, ...] = ()
    part: str = ""
    spare_part: str = ""
    code: CodeKind | Callable[[SourceT], CodeKind] = ""
    named: Callable[[SourceT], str] | None = None

    def applies(self, source: SourceT) -> bool:
        """Return whether *source* has the capability."""
        return self.when is None or bool(self.when(source))

    def describe(self, source: SourceT, *, assumed: bool = False) -> Capability | None:
        """Return the capability of *source*; None if it has none.

        Args:
            assumed: Whether it reports its last command.
        """
        if not self.applies(source):
            return None
        settable = self.write is not None and _told(self.settable, source)
        readable = self.read is not None or not settable if self.readable is None else self.readable(source)
        return Capability(
            name=self.capability if self.named is None else self.named(source),
            readable=readable,
            settable=settable,
            unit=_told(self.unit, source),
            bounds=_told(self.bounds, source),
            options=_told(self.options, source),
            grid=_told(self.grid, source),
            echoed=assumed and readable and settable,
            code=_told(self.code, source),
        )


def _told(column: ToldT | Callable[[SourceT], ToldT], source: SourceT) -> ToldT:
    return column(source) if callable(column) else column


def described(
    rows: Iterable[CapabilityRow[SourceT, ReadT, WriteT]], source: SourceT, *, assumed: bool = False
) -> list[tuple[Capability, CapabilityRow[SourceT, ReadT, WriteT]]]:
    """Return the capabilities of *source*, each with its row; see :meth:`CapabilityRow.describe`."""
    pairs = [(row.describe(source, assumed=assumed), row) for row in rows]
    return [(capability, row) for capability, row in pairs if capability is not None]


def writer_of(rows: Iterable[CapabilityRow[SourceT, ReadT, WriteT]], capability: str) -> WriteT:
    """Return the writer of *capability*.

    Raises:
        RefusedError: It is not settable; names those that are.
    """
    settable = {row.capability: row.write for row in rows if row.write is not None}
    if capability not in settable:
        raise RefusedError(shown(capability), f"this part takes {', '.join(settable) or 'nothing'}")
    return settable[capability]
