"""A device as its gateway publishes it: what all its sightings have in common, and what was published last. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal, TypeAlias

from homebot.conventions.description import TextEndpoint
from homebot.devices import KeyValue, Sighting
from homebot.devices.names import text_address
from homebot.devices.part import Part
from homebot.devices.text.encode import accepts_text, main_part
from homebot.messages import Time

__all__ = ["ReportedDevice", "SightingKind", "sighting_template"]

SightingKind: TypeAlias = Literal["appeared", "updated", "removed"]

_MAX_STREAMS = 100
_NEVER = Time(sec=0, nanosec=0)


@dataclass(slots=True, eq=False)
class ReportedDevice:
    """A device, or one announcement of it, that a gateway publishes.

    Attributes:
        gateway: The gateway.
        key: What that gateway calls it.
        is_confirmed: Whether the last sighting was a sign of life of the device itself.
        refresh_at: Reading of the monotonic clock from which on another sign of life is worth a sighting.
        reachable: Whether the device (``""``) and its parts can be reached, as it was published last.
        report_streams: The streams of reports that late joiners get.
        template: A sighting with all that its sightings have in common.
    """

    gateway: str
    key: str
    is_confirmed: bool = field(default=False, init=False)
    refresh_at: float = field(default=0.0, init=False)
    reachable: dict[str, bool | None] = field(default_factory=dict, init=False)
    report_streams: set[str] = field(default_factory=set, init=False)
    template: Sighting = field(init=False)

    def publishes_the_same(self, other: ReportedDevice) -> bool:
        """Tell whether the graph sees no difference between the two."""
        return self.template == other.template

    def report_stream(self, address: str) -> str:
        """Return the name of the stream of what is said on *address*; of a device with hundreds, they share one."""
        name = f"{self.key} {address}"
        if name not in self.report_streams:
            if len(self.report_streams) >= _MAX_STREAMS:
                name = f"{self.key} *"
            self.report_streams.add(name)
        return name

    def sighting(
        self, kind: SightingKind, why: str, *, at: Time, until: Time, heard_at: float, confirmed: bool
    ) -> Sighting:
        """Return a sighting of it."""
        times = {"seen_at": at, "expires_at": until, "heard_at": heard_at}
        return Sighting.of_checked(
            **{**self.template.__dict__, "kind": kind, "why": why, "confirmed": confirmed, **times}
        )


def sighting_template(
    gateway: str,
    key: str,
    *,
    name: str,
    parts: tuple[Part, ...],
    metadata: Mapping[str, str],
    identifiers: tuple[str, ...],
    area: str,
    convention: str = "",
    native: bool = True,
    whole_device: bool = False,
    owns: tuple[str, ...] = (),
    announced_on: str = "",
    text: TextEndpoint | None = None,
) -> Sighting:
    """Return what all sightings of a device have in common; its addresses are those of its main part's texts.

    One that says *text* by itself has the addresses, and the service type, of that.
    What a gateway says itself is native; see :class:`~homebot.devices.Sighting`.

    Raises:
        pydantic.ValidationError: A value is none that a sighting can have.
    """
    main = main_part(parts)
    if text is None:
        address = "" if main is None else text_address(key, main.id)
        is_told = main is not None and accepts_text(main)
        text = TextEndpoint("" if main is None else main.service_type, address, address if is_told else "")
    checked = Sighting(
        gateway=gateway,
        key=key,
        kind="updated",
        why="",
        name=name,
        service_type=text.service_type,
        address=text.address,
        command_address=text.command_address,
        metadata=tuple(_fact(fact, value) for fact, value in metadata.items()),
        convention=convention,
        native=native,
        whole_device=whole_device,
        identifiers=identifiers,
        area=area,
        parts=parts,
        owns=owns,
        announced_on=announced_on,
        seen_at=_NEVER,
        expires_at=_NEVER,
        confirmed=False,
    )
    return Sighting.of_checked(**checked.__dict__)  # without a set of its fields of its own, which is 2 kB


@lru_cache(maxsize=10_000)
def _fact(key: str, value: str) -> KeyValue:
    return KeyValue(key=key, value=value)
