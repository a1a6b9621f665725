"""Grants of the nodes of apps: an unchanging statement, and the place where it is replaced whole."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final


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
