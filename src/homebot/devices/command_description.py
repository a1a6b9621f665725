"""Description of a part's commands, to which an approval is bound. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import blake2b
from typing import NamedTuple

from homebot.devices.part import Part

__all__ = ["CommandDescription", "payload_digest"]

_DIGEST_BYTES = 16


def payload_digest(announced: object) -> str:
    """Return the digest of *announced*, the plain values that determine the payloads of commands."""
    return blake2b(repr(announced).encode(errors="surrogatepass"), digest_size=_DIGEST_BYTES).hexdigest()


class CommandDescription(NamedTuple):
    """Announced facts about the commands of a part.

    Attributes:
        identifiers: The identifiers of the device, sorted.
        payloads: See :attr:`homebot.devices.part.Part.payloads`.
    """

    service_type: str
    identifiers: tuple[str, ...]
    topics: tuple[str, ...]
    settings: tuple[str, ...]
    payloads: str

    @classmethod
    def of(cls, part: Part, identifiers: tuple[str, ...]) -> CommandDescription:
        """Return the description of *part*, announced with the *identifiers* of its device."""
        settings = tuple([one.name for one in part.capabilities if one.settable])
        return cls(part.service_type, tuple(sorted(identifiers)), part.writes, settings, part.payloads)

    @property
    def digest(self) -> str:
        """Digest of all fields."""
        return payload_digest(tuple(self))

    def changes(self, before: CommandDescription) -> str:
        """Return the differences from *before* as text; empty if there are none."""
        return "; ".join(self._changes(before))

    def _changes(self, before: CommandDescription) -> Iterator[str]:
        if self.service_type != before.service_type:
            yield f"its type is {self.service_type}, it was {before.service_type}"
        for name, now, then in (
            ("its commands go to", self.topics, before.topics),
            ("it takes", self.settings, before.settings),
            ("its identifiers are", self.identifiers, before.identifiers),
        ):
            if now != then:
                yield f"{name} {_listed(now)} instead of {_listed(then)}"
        if self.payloads != before.payloads:
            yield "the payloads of its commands changed"


_MOST_LISTED = 5
_LONGEST = 100


def _listed(words: tuple[str, ...]) -> str:
    shown = ", ".join([one[:_LONGEST] for one in words[:_MOST_LISTED]])
    return (f"{shown}, …" if len(words) > _MOST_LISTED else shown) or "none"
