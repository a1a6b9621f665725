"""The node of the control layer: the services for commands, leases, the journal and its explanations."""

# ruff: noqa: PLW0108 - the lambdas build the layer with the first request

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping
from functools import cached_property, partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Final, final

import anyio
from anyio.abc import TaskStatus

from homebot.control.gateway_feed import GatewayFeed
from homebot.devices import GatewayNames, RawCommand, names
from homebot.devices import lease_messages as leases
from homebot.devices.access_messages import AccessRefused
from homebot.devices.approval_messages import GetUnapproved, TrustDevice
from homebot.devices.capabilities import SETTABLE
from homebot.devices.client_rights import CurrentGrants
from homebot.devices.command_messages import CommandDevices, PerformCommand, SendText
from homebot.devices.device import ChangedSetting, ChangedSettings
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.names import DEVICE_SETTINGS, DIRECTORY_NODE
from homebot.graph import OTHERS, Node, QoSProfile, ReliabilityPolicy
from homebot.support.production_loop import load_beside_loop

if TYPE_CHECKING:
    from datetime import time

    from homebot.control.actions import ControlActions
    from homebot.control.control_layer import ControlLayer
    from homebot.control.open_command import SimulatedExecution
    from homebot.control.settings import ControlSettings
    from homebot.devices import Device, DevicePart
    from homebot.devices.command_messages import CommandDevicesRequest, CommandDevicesResponse, CommandRequest
    from homebot.devices.misspelt_names import ConfiguredNames
    from homebot.devices.outcomes import Outcome, Refused
    from homebot.journal.store import JournalStore

_REFUSALS: Final = 1000


_SETTINGS: Final = QoSProfile(depth=100)
"""Each message has the changes of half a second; in a flood the oldest is dropped."""

_QUESTIONS: Final = {names.GET_QUESTIONS: "GetQuestions", names.ANSWER_QUESTION: "AnswerQuestion"}
_REASONS: Final = {
    names.GET_CAUSES: "GetCauses",
    names.READ_JOURNAL: "ReadJournal",
    names.EXPLAIN_DEVICE: "ExplainDevice",
    names.EXPLAIN_MISSING_STATE: "ExplainMissingState",
}
"""Services whose messages are loaded with the first call, with their types."""

_RAW: Final = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
"""In a flood the oldest is dropped; a gateway's commands never wait for the journal."""

_LAYER: Final = "homebot.control.control_layer"

_CALM: Final = 10.0
"""Seconds in which further numbers of one setting are not recorded: from a dial that is turned, or a moving blind."""


def _is_change(change: ChangedSetting) -> bool:
    """Return whether a setting changed from one known value to another, and is no dial that is still turned."""
    value, before = change.value.plain(), change.before.plain()
    if change.capability not in SETTABLE or None in (value, before) or value == before:
        return False
    is_soon = change.told_at.to_seconds() - change.before_since.to_seconds() < _CALM
    return not (isinstance(value, float) and value and before and is_soon)


@final
class HouseWatch:
    """Records unexplained changes and raw commands in the journal.

    The first value of each setting is not a change.

    Args:
        layer: Returns the control layer, which is built for the first entry.
        load: Loads its modules.
        is_dry_run: Whether gateways send nothing, so raw commands have no effect.
    """

    def __init__(
        self,
        node: Node,
        lookup: DeviceLookup,
        layer: Callable[[], ControlLayer],
        load: Callable[[], Awaitable[None]],
        *,
        is_dry_run: bool,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._layer = layer
        self._load = load
        self._is_dry_run = is_dry_run

    def follow_settings(self) -> None:
        """Record changes of settings from now on."""
        self._node.create_subscription(
            ChangedSettings, DEVICE_SETTINGS, self._on_settings, _SETTINGS, from_node=DIRECTORY_NODE
        )

    def follow_gateway(self, gateway: str) -> None:
        """Record the raw commands to a gateway from now on."""
        out = GatewayNames(gateway).out
        self._node.create_subscription(RawCommand, out, partial(self._on_raw, gateway), _RAW, from_node=OTHERS)

    async def _on_settings(self, changed: ChangedSettings) -> None:
        changes = [change for change in changed.changes if _is_change(change)]
        if changes:
            await self._load()
            if (learnt := self._layer().learnt).is_awaited:
                await learnt.load()
        for change in changes:
            layer, place = self._layer(), (change.device, change.part)
            is_known = layer.timelines.cause(change) is not None
            if not is_known and (device := await self._lookup.known(change.device)) is not None:
                layer.timelines.add(device, [other for other in changes if (other.device, other.part) == place])
            layer.sending.reports.on_change(change)

    async def _on_raw(self, gateway: str, command: RawCommand) -> None:
        # Control's own commands do not come here; an id that another program gives would let it hide the command.
        now, command = self._clock.now(), command.model_copy(update={"command_id": ""})
        device_id = await self._lookup.device_at(gateway, command.address)
        if not device_id:
            return
        layer = self._layer()
        name = layer.journal.record_sent(device_id, command, now, is_sent=not self._is_dry_run)
        if self._is_dry_run or (device := await self._lookup.known(device_id)) is None:
            return
        await layer.executor.record_raw(name, device, gateway, command)


def _load_layer() -> None:
    import_module(_LAYER)


def _load_reasons() -> None:
    _load_layer()
    import_module("homebot.devices.journal_messages")


@final
class Control:
    """The only path for commands from applications to devices.

    Most homes start without a command, so its parts are built when they are first needed.

    Args:
        settings: The table ``[control]``.
        grants: The scopes of nodes in force, see `CommandRequest`; None for no limits.
        trusts_apps: Whether nodes without a scope may command devices that always ask, as in a simulated house.
        approves_all: Whether no device needs an approval, regardless of the settings, as in a simulated house.
        journal_file: The file of the journal and the device profiles; None to store neither.
        store: The store to use instead of a file.
        rehearsal: Answers commands in place of the devices; None if they are sent.
        detected: Motion sensors that detected a person before; see :meth:`detected`.
        scopes: Returns the rights in the configuration by key, in which names may be misspelt.
    """

    def __init__(
        self,
        node: Node,
        settings: ControlSettings | None = None,
        grants: CurrentGrants | None = None,
        *,
        trusts_apps: bool = False,
        approves_all: bool = False,
        journal_file: Path | None = None,
        store: JournalStore | None = None,
        rehearsal: SimulatedExecution | None = None,
        detected: Iterable[str] = (),
        scopes: Callable[[], Mapping[str, Iterable[str]]] = dict,
    ) -> None:
        self._node = node
        self._given_settings = settings
        self._scopes = scopes
        self._approves_all = approves_all
        self._journal_file = journal_file
        lookup = DeviceLookup(node)
        self._feed = GatewayFeed(node)
        is_dry_run = rehearsal is not None and rehearsal.is_live
        self._house_watch = HouseWatch(node, lookup, lambda: self._layer, self._load, is_dry_run=is_dry_run)

        self._build: Callable[[type[ControlLayer]], ControlLayer] = lambda kind: kind(
            node,
            self._feed,
            lookup,
            self._given_settings,
            grants or CurrentGrants(),
            trusts_apps=trusts_apps,
            approves_all=approves_all,
            detected=detected,
            journal_file=journal_file,
            store=store,
            rehearsal=rehearsal,
        )
        self._feed.on_gateway = self._house_watch.follow_gateway
        self._begun, self._has_names = anyio.Event(), anyio.Event()
        self._loading = anyio.Lock()  # commands keep their order
        self._begin_check()
        if settings is not None and settings.needs_house:
            _ = self._layer  # the layer follows the house from the start

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled."""
        self.register()
        async with anyio.create_task_group() as tasks:
            self._house_watch.follow_settings()
            tasks.start_soon(self._feed.run)
            tasks.start_soon(self._check_names)
            task_status.started()
            try:
                if self._journal_file is not None and await anyio.Path(self._journal_file).exists():
                    tasks.start_soon(self._layer.learnt.load)  # before the first command
                await self._begun.wait()
                await self._layer.run()
            finally:
                if self._begun.is_set():
                    await self._layer.close()

    def register(self) -> None:
        """Create the services and subscriptions."""
        create, qos = self._node.create_service, QoSProfile(depth=_REFUSALS)
        create(PerformCommand, names.PERFORM_COMMAND, self.perform, concurrent=True)
        create(SendText, names.SEND_TEXT, lambda request: self._layer.executor.send_text(request), concurrent=True)
        create(CommandDevices, names.COMMAND_DEVICES, self._command_devices, concurrent=True)
        create(leases.HoldPart, names.HOLD_PART, lambda request: self._layer.leases.hold(request), concurrent=True)
        create(leases.RenewLease, names.RENEW_LEASE, lambda request: self._layer.leases.renew(request))
        create(leases.ReleaseLease, names.RELEASE_LEASE, lambda request: self._layer.leases.release(request))
        create(leases.GetLeases, names.GET_LEASES, lambda request: self._layer.leases.held_parts(request))
        create(leases.EndLeases, names.END_LEASES, lambda request: self._layer.leases.end(request))
        create(GetUnapproved, names.GET_UNAPPROVED, lambda request: self._layer.policies.unapproved(request))
        create(TrustDevice, names.TRUST_DEVICE, lambda request: self._layer.sending.witnesses.trust(request))
        for name, kind in _QUESTIONS.items():
            self._node.offer_service(f"homebot/srv/{kind}", name, partial(self._serve_questions, name), _load_layer)
        for name, kind in _REASONS.items():
            self._node.offer_service(f"homebot/srv/{kind}", name, partial(self._serve_reasons, name), _load_reasons)
        create(GetHealth, "~/health", self.health)
        offer = self._node.offer_action
        load = partial(import_module, "homebot.control.actions")
        offer("homebot/action/CommandDevices", names.PERFORM_COMMANDS, lambda: self._actions.serve_commands(), load)
        offer("homebot/action/HoldDevice", names.HOLD_DEVICE, lambda: self._actions.serve_holds(), load)
        self._node.create_subscription(
            AccessRefused, names.ACCESS_REFUSALS, lambda refused: self._layer.denied.record(refused), qos
        )

    def _serve_questions(self, name: str) -> None:
        self._layer.executor.questions.serve(name)

    def _serve_reasons(self, name: str) -> None:
        from homebot.devices import journal_messages as journal  # noqa: PLC0415 - with the first question

        create, layer = self._node.create_service, self._layer
        match name:
            case names.GET_CAUSES:
                create(journal.GetCauses, name, layer.sending.reports.causes, concurrent=True)
            case names.READ_JOURNAL:
                create(journal.ReadJournal, name, layer.journal.read, concurrent=True)
            case names.EXPLAIN_DEVICE:
                create(journal.ExplainDevice, name, layer.explanations.explain, concurrent=True)
            case _:
                create(journal.ExplainMissingState, name, layer.explanations.explain_missing, concurrent=True)

    def perform(self, request: CommandRequest) -> Awaitable[Outcome]:
        """Carry out a command to one part, and return its outcome."""
        if self._begun.is_set() and not self._loading.locked():
            return self._layer.executor.perform(request)
        return self._perform_first(request)

    async def _command_devices(self, request: CommandDevicesRequest) -> CommandDevicesResponse:
        await self._load()
        return await self._layer.words.serve(request)

    async def _perform_first(self, request: CommandRequest) -> Outcome:
        await self._load()
        return await self._layer.executor.perform(request)

    def preview(self, request: CommandRequest, device: Device, part: DevicePart) -> Refused | None:
        """Return why a command would be refused now; None if it would not."""
        return self._layer.executor.preview(request, device, part)

    def why_asked(self, request: CommandRequest, device: Device, part: DevicePart) -> Awaitable[str]:
        """Return why a person must agree to a command; empty if none must, or it would be refused."""
        return self._layer.executor.why_asked(request, device, part)

    def record_note(self, devices: Iterable[str], issuer: str, text: str) -> None:
        """Record an act of *issuer* with *devices* for a goal other than by commands, as *text* says."""
        for device in devices:
            self._layer.journal.goal(device, issuer, text)

    def quiet_hours(self) -> tuple[tuple[time, time], ...]:
        """Return the quiet hours, each with its local start and end."""
        settings = self._given_settings
        return () if settings is None else tuple((hours.start, hours.end) for hours in settings.quiet_hours)

    def update_policies(self, settings: ControlSettings | None) -> bool:
        """Use the policies of *settings*; changes of its other keys wait for a restart.

        Returns:
            Whether dangerous devices wait for an approval.
        """
        self._given_settings = settings
        self._begin_check()
        if self._begun.is_set() or (settings is not None and settings.needs_house):
            self._layer.update_policies(settings, approves_all=self._approves_all)
        return not self._approves_all and (settings is None or settings.approvals)

    def forget_rights(self) -> None:
        """Judge the rights of nodes anew, after a change of the grants."""
        if self._begun.is_set():
            self._layer.policies.rights.cache_clear()
        self._begin_check()

    async def detected(self) -> tuple[str, ...]:
        """Return the motion sensors that have ever detected a person: the presence guard trusts only them."""
        settings = self._given_settings
        return await self._layer.policies.detected() if settings is not None and settings.needs_house else ()

    async def health(self, _: HealthRequest) -> HealthResponse:
        """Return the health of the journal, notes for the owner, and names in the settings that fit nothing."""
        await self._load()
        health = await self._layer.health()
        problems = await self._names.problems() if self._has_names.is_set() else ()
        return health.model_copy(update={"troubles": health.troubles + problems}) if problems else health

    def _begin_check(self) -> None:
        """Start the check of names if the settings or the rights have any: few homes do."""
        is_stated = self._given_settings is not None and any(self._given_settings.stated_names)
        if is_stated or any(":" in right for scope in self._scopes().values() for right in scope):
            self._has_names.set()

    async def _check_names(self) -> None:
        await self._has_names.wait()
        await self._names.run()

    @cached_property
    def _names(self) -> ConfiguredNames:
        """The check of the names in the settings and the rights, after a reload too."""
        from homebot.devices.misspelt_names import ConfiguredNames, StatedNames  # noqa: PLC0415 - see _begin_check
        from homebot.words.rights import patterns_of_rights  # noqa: PLC0415 - see _begin_check

        def stated() -> StatedNames:
            named = StatedNames() if self._given_settings is None else self._given_settings.stated_names
            return named._replace(patterns=(*named.patterns, *patterns_of_rights(self._scopes())))

        return ConfiguredNames(self._node, stated)

    async def _load(self) -> None:
        """Load the modules of the layer, without letting others wait for 100 ms."""
        if self._loading.locked() or not self._begun.is_set():
            async with self._loading:
                await load_beside_loop(_load_layer)

    @cached_property
    def _layer(self) -> ControlLayer:
        from homebot.control.control_layer import ControlLayer  # noqa: PLC0415 - loaded with the first command

        layer = self._build(ControlLayer)
        self._begun.set()
        return layer

    @cached_property
    def _actions(self) -> ControlActions:
        from homebot.control.actions import ControlActions  # noqa: PLC0415 - loaded with the first action

        return ControlActions(self._node, lambda: self._layer)
