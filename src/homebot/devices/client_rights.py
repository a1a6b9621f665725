"""Rights of external programs, and grants of apps. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, final

from homebot.devices.always_ask import is_declared
from homebot.devices.device import Device, DevicePart
from homebot.devices.names import TAG
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.terms import And, FactIs, NameIs, Or, Query, TypeIs
from homebot.devices.trigger import Trigger
from homebot.rights import Right

CLIENT = "client:"
"""The beginning of an issuer that is a client of the door."""

LOCAL_CLIENT = "local"
"""The name of clients without a token."""

OWNER_CLIENT = "owner"
"""The name of clients with the one unnamed token."""

EDIT_ROUTINE = "homebot routine edit "
"""The beginning of the command that changes a routine that homebot keeps."""

CLIENT_RIGHTS = "rights"
"""The name of the policy that refuses clients of the door."""

ASK = "ask"
"""The name of the policy that refuses commands without a person's agreement."""

HARMLESS = "harmless"
"""In place of a query: everything on the list of :mod:`homebot.devices.harmless`."""

ORDINARY = "ordinary"
"""In place of a query: every device except those that always ask."""

ALL_ROBOTS = "all"
"""In place of a robot's name: every robot."""


class ClientRights(NamedTuple):
    """The rights of one client.

    Attributes:
        acts_on: It may command devices that fit any of these queries. For one that always asks
            (:mod:`homebot.devices.always_ask`) a query must name its type or name: fitting ``in hall`` is not enough. A
            room that is known only from a tag does not count.
        acts_on_harmless: Whether it may command what is on the list of harmless parts.
        acts_on_ordinary: Whether it may command all that does not always ask.
        acts_on_all: Whether it may command every device.
        asks_on: A person must agree to each of its commands to devices that fit any of these queries; it may command
            them, as with *acts_on*, even if no other right covers them.
        asks_on_all: Whether a person must agree to each of its commands.
        act_scope: The six above as they were written, for commands; empty for the rights without a scope.
        robots: The names of the robots that it may act as; :data:`ALL_ROBOTS` for any.
        table: The table of the configuration that may have the key ``act``, in words, or the command that changes a
            kept routine; empty if it has neither.
    """

    kinds: frozenset[Right] = frozenset()
    acts_on: tuple[Query, ...] = ()
    acts_on_harmless: bool = False
    acts_on_ordinary: bool = False
    acts_on_all: bool = False
    asks_on: tuple[Query, ...] = ()
    asks_on_all: bool = False
    act_scope: tuple[str, ...] = ()
    robots: tuple[str, ...] = ()
    table: str = ""

    def has(self, right: Right) -> bool:
        """Return whether the client has *right*; for ``act``, on any device."""
        return right in self.kinds

    def may_be(self, robot: str) -> bool:
        """Return whether it may act as *robot*, or as any robot if that is empty."""
        return bool(self.robots) and (not robot or robot in self.robots or ALL_ROBOTS in self.robots)

    def must_ask(self, device: Device, part: DevicePart) -> bool:
        """Return whether a person must agree to each command to *part* of *device*; a room of a tag counts here."""
        return self.asks_on_all or any(fits(query, PartFacets(device, part)) for query in self.asks_on)

    def may_command(self, device: Device, part: DevicePart, *, asks: bool, is_harmless: bool) -> bool:
        """Return whether it may command *part* of *device*, perhaps only if a person agrees.

        Args:
            asks: Whether the part always asks.
            is_harmless: Whether it is on the list of harmless parts.
        """
        if (
            self.acts_on_all
            or self.asks_on_all
            or (is_harmless and self.acts_on_harmless)
            or (not asks and self.acts_on_ordinary)
        ):
            return True
        facets = PartFacets(without_taught_room(device), part)
        declared = is_declared(part)

        def names_it(query: Query) -> bool:
            match query:
                case And(terms) | Or(terms):
                    return any(map(names_it, terms))
                case TypeIs():
                    return declared and fits(query, facets)
                case NameIs() | FactIs("id" | "name"):
                    return fits(query, facets)
                case _:
                    return False

        return any(fits(query, facets) and (not asks or names_it(query)) for query in self.acts_on + self.asks_on)

    @property
    def text(self) -> str:
        """The names of the rights, for people."""
        names = [right.value for right in Right if right is not Right.ROBOT and self.has(right)]
        return ", ".join((*names, *(f"robot: {name}" for name in self.robots))) or "none"


LOCAL_RIGHTS = ClientRights(frozenset({Right.READ, Right.ACT}), acts_on_harmless=True)
"""The rights of a client without a token: it reads, and commands what is on the list of harmless parts."""

APP_RIGHTS = LOCAL_RIGHTS._replace(acts_on_ordinary=True)
"""The rights of an app without ``act``, which the owner installed: it commands all that does not always ask."""

ALL_RIGHTS = APP_RIGHTS._replace(
    kinds=frozenset(Right), acts_on_all=True, act_scope=("act: all",), robots=(ALL_ROBOTS,)
)
"""The rights of the one unnamed token, and of the owner's in the data folder."""

SIMULATED_HOUSE_RIGHTS = ALL_RIGHTS
"""The rights of a client without a token if no real device can be reached."""


def issuer_of_client(name: str) -> str:
    """Return the issuer of the commands of the client *name*."""
    return CLIENT + name


def is_client(issuer: str) -> bool:
    """Return whether *issuer* is a client rather than a node."""
    return issuer.startswith(CLIENT)


def is_from_person(issuer: str, trigger: Trigger) -> bool:
    """Return whether a person gave a command by the client *issuer*: neither a program nor a scene led to it."""
    return is_client(issuer) and not (trigger.kind or trigger.scene)


def without_taught_room(device: Device) -> Device:
    """Return *device* without its room if only a tag or code states it; otherwise the same device.

    A tag anywhere can name a room, so it grants no rights. A room that the owner states, in the configuration or by a
    command, or that the device itself announces is kept.
    """
    conventions = (
        {fact.convention for fact in device.facts if fact.name in {"area", "position"}} if device.area else set()
    )
    return device.model_copy(update={"area": "", "outer_areas": ()}) if conventions == {TAG} else device


@final
@dataclass(frozen=True, slots=True)
class NodeGrants:
    """The scopes of nodes at one moment.

    Attributes:
        scopes: The scope of each node that may not command everything, by its full name.
        tables: The table of each app or routine that may have the key ``act``, in words, likewise, or the command that
            changes a kept routine.
    """

    scopes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    tables: Mapping[str, str] = field(default_factory=dict)

    def without(self, node: str) -> "NodeGrants":
        """Return them without those of *node*."""
        scopes, tables = dict(self.scopes), dict(self.tables)
        scopes.pop(node, None)
        tables.pop(node, None)
        return NodeGrants(scopes, tables)

    def having(self, node: str, table: str, scope: tuple[str, ...] | None) -> "NodeGrants":
        """Return them with those of *node*, which may command everything if *scope* is None."""
        rest = self.without(node)
        scopes = rest.scopes if scope is None else {**rest.scopes, node: scope}
        return NodeGrants(scopes, {**rest.tables, node: table})


@final
@dataclass(slots=True)
class CurrentGrants:
    """The place of the grants in force."""

    now: NodeGrants = field(default_factory=NodeGrants)
