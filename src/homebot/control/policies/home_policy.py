"""Policies of other packages: the contract, and their classes by entry point. Pure."""

import logging
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import ClassVar, Final, TypeAlias, final

from pydantic import BaseModel, ConfigDict

from homebot.config import parse_settings
from homebot.control.command import IssuedCommand
from homebot.control.policies.facts import Facts, Verdict
from homebot.devices.query.terms import Query
from homebot.errors import ConfigError, PluginError, UsageError
from homebot.plugins import has_plugin, load_plugin, plugin_names
from homebot.support.names import did_you_mean

POLICIES: Final = "homebot.policies"
"""The entry-point group."""

PolicyTables: TypeAlias = dict[str, dict[str, object]]
"""The tables ``[control.policies.NAME]`` by name."""

_logger = logging.getLogger(__name__)


class NoPolicySettings(BaseModel):
    """The table of a policy that has no keys."""

    model_config = ConfigDict(extra="forbid")


class HomePolicy(ABC):
    """A policy of another package: a pure function of a command and the facts, without waiting or I/O.

    Args:
        settings: Its validated table of the configuration, an instance of :attr:`Settings`.

    Attributes:
        needs: The query for the devices that the policy reads from ``facts.house``; None for none.
    """

    Settings: ClassVar[type[BaseModel]] = NoPolicySettings
    needs: Query | None = None

    def __init__(self, settings: BaseModel) -> None:
        del settings

    @abstractmethod
    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Return the verdict; its policy name is replaced by the name of the table."""


@final
class NamedPolicy:
    """A policy under the name of its table; if it fails, it refuses the command."""

    def __init__(self, name: str, policy: HomePolicy) -> None:
        self.name = name
        self.policy = policy
        self.needs = policy.needs
        self._has_failed = False

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        """Return the verdict of the policy under its name."""
        try:
            verdict = self.policy.judge(command, facts)
            return Verdict(self.name, verdict.allowed, verdict.reason, verdict.facts)
        except Exception as exc:  # code of another package; it did not allow the command
            if not self._has_failed:
                self._has_failed = True
                _logger.exception("the policy %s failed, and refuses every command that it checks", self.name)
            return Verdict(
                self.name,
                allowed=False,
                reason=f"the policy failed: {type(exc).__name__}: {exc}"[:_MAX_REASON_CHARACTERS],
            )


_MAX_REASON_CHARACTERS: Final = 200


def home_policies(tables: Mapping[str, Mapping[str, object]]) -> Iterator[NamedPolicy]:
    """Yield the policies of *tables*.

    Raises:
        UsageError: A name is not an installed policy, or its table is wrong; names the remedy.
    """
    for name, table in tables.items():
        if not has_plugin(POLICIES, name):  # no module or file is loaded: a recording may name one
            known = plugin_names(POLICIES)
            hint = did_you_mean(name, known, f"installed are {', '.join(known) or 'none'}")
            raise UsageError(f"no installed package offers the policy {name!r}; {hint}")
        kind = load_plugin(POLICIES, name)
        if not issubclass(kind, HomePolicy):
            raise PluginError(name, f"{kind.__name__} is not a HomePolicy; derive it from {HomePolicy.__module__}")
        try:
            settings = parse_settings(kind.Settings, table, POLICIES, name)
        except ConfigError as exc:
            raise UsageError(f"{exc.key}: {exc.reason}") from None
        yield NamedPolicy(name, kind(settings))


def check_tables(tables: PolicyTables) -> PolicyTables:
    """Return *tables* if installed policies accept them.

    Raises:
        ValueError: One rejects its table; for :mod:`pydantic`.
    """
    try:
        for _ in home_policies(tables):
            pass
    except UsageError as exc:
        raise ValueError(str(exc)) from exc
    return tables
