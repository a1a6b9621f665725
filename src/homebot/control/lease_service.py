"""Services for leases: each held value is commanded, watched, and commanded again if it changes."""

import math
from functools import partial
from typing import Final, final

import anyio

from homebot.control.command import commanded_part, device_settings
from homebot.control.executor import CommandExecutor
from homebot.control.journal.given_codes import without_codes
from homebot.control.journal.journal import CommandJournal, LeaseStep
from homebot.control.leases import LEASE_POLICY, HolderKey, Lease, LeaseHolder
from homebot.control.timeline.cause import HeldValue
from homebot.control.timeline.facts import Attribution, ReportRole
from homebot.devices import Device, DevicePart
from homebot.devices.capabilities import MOMENTARY
from homebot.devices.client_rights import is_client
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.device import target_of
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.device_names import ask_which
from homebot.devices.lease_messages import (
    EndLeasesRequest,
    GetLeasesRequest,
    HeldPart,
    HolderOfPart,
    HolderRequest,
    HoldRequest,
    LeasesResponse,
    LeaseState,
)
from homebot.devices.outcomes import Contradicted, Gone, NoAnswer, Outcome, Refused, no_such_part
from homebot.devices.part import check_setting
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import PlainValue
from homebot.devices.value_comparison import STOPPED, value_text
from homebot.errors import RefusedError, ServiceError
from homebot.graph import Node
from homebot.messages import Time

_REPEATED_AFTER_S: Final = 30.0
"""Seconds after which the value is commanded again if a command had no success, or the device soon went back."""

_MAX_TEXT_CHARACTERS: Final = 200

_NOT_HELD: Final = "there is no such lease: it is over or was released"


@final
class LeaseService:
    """Commands the held values, watches them, and commands them again if they change."""

    def __init__(self, node: Node, lookup: DeviceLookup, executor: CommandExecutor, journal: CommandJournal) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._executor = executor
        self._journal = journal
        self._leases = executor.leases
        self._leases.on_outranked = self._on_outranked
        self._changed = anyio.Event()

    async def run(self) -> None:
        """End leases when they are due, and command values again, until cancelled."""
        async with anyio.create_task_group() as tasks:
            while True:
                self._changed = anyio.Event()
                self._expire()
                for lease in self._leases:
                    if lease.again_at <= self._clock.monotonic():
                        self._hand_back(lease)
                        tasks.start_soon(self._command, lease, *next(iter(lease.holders.items())))
                left = self._leases.next_time() - self._clock.monotonic()
                with anyio.move_on_after(None if left == math.inf else max(0.0, left)):
                    await self._changed.wait()

    async def hold(self, request: HoldRequest) -> LeaseState:
        """Command a value and hold it; return once the outcome of the command is known."""
        target = await self._target(request)
        if not isinstance(target, tuple):
            return LeaseState(held=False, outcome=target)
        device, part = target
        # with ids, and with the value that will be sent
        wanted = request.setting
        ((capability, value),) = device_settings({wanted.capability: wanted.value.plain()}, part.part).items()
        trigger = NO_TRIGGER if is_client(request.issuer) else request.trigger  # a client could forge one
        held = Setting.of(capability, value)
        request = request.model_copy(update={"device": device.id, "part": part.id, "setting": held, "trigger": trigger})
        key = _key(request)
        holder = LeaseHolder(
            request.by,
            request.ttl,
            self._clock.monotonic() + request.ttl,
            request.scope,
            request.trigger,
            request.is_open_ended,
            request.yields_to_persons,
            request.transition,
        )
        if (refused := self._refusal(request, holder, device, part)) is not None:  # before it blocks others
            return refused
        lease = self._begin(request, holder)
        if isinstance(lease, str):
            return self._refuse(request, lease)
        if lease.stop_watch is None:
            timeline = self._executor.timelines.of(device, part)
            lease.held = HeldValue(lease.capability, lease.value, timeline.profile, partial(self._on_report, lease))
            timeline.held.append(lease.held)
            lease.stop_watch = partial(timeline.held.remove, lease.held)
            self._changed.set()
        self._log("control.held", lease, f"is {lease.text(self._clock.monotonic())}")
        self._record("held", lease, request.issuer, request.by, request.trigger)
        outcome = await self._command(lease, key, holder)
        if outcome is None:  # the lease ended, or a hand outranked it, before its turn
            self._release(key)
            return self._refuse(request, "a hand outranks it now, or its time is over")
        if outcome.is_final and key in lease.holders:
            self._release(key)
        return LeaseState(key in lease.holders, outcome)

    async def _target(self, request: HoldRequest) -> tuple[Device, DevicePart] | NoAnswer | Gone:
        try:
            called = await self._lookup.find_called(request.device)
        except ServiceError as exc:
            return NoAnswer(0.0, str(exc))
        if len(called) > 1:
            return Gone(ask_which(request.device, called))
        device = called[0] if called else None
        part = commanded_part(device, request.part, (request.setting,))
        if device is None or part is None:
            return no_such_part(request.device, request.part, device)
        return device, part

    def renew(self, request: HolderRequest) -> LeaseState:
        """Renew the lease of a holder, and return its state."""
        now = self._clock.monotonic()
        lease = self._leases.renew(_key(request), now)
        if lease is None:
            return LeaseState(held=False, outcome=Refused(LEASE_POLICY, _NOT_HELD))
        outcome = lease.outcome
        if now < lease.hand_until:  # a hand made a change since
            left = f"; it is commanded again in {math.ceil(lease.hand_until - now)} s"
            outcome = Contradicted(lease.saw if lease.yielded_to else f"{lease.saw}{left}")
        return LeaseState(held=True, outcome=outcome)

    def release(self, request: HolderRequest) -> LeaseState:
        """End the lease of a holder, and return its state; a holder without a lease is refused."""
        state = self.renew(request)
        lease = self._release(_key(request))
        if lease is not None:
            self._log("control.released", lease, f"is no longer held {lease.held_value} by {request.by}")
        return state._replace(held=False)

    def held_parts(self, request: GetLeasesRequest) -> LeasesResponse:
        """Return the held parts."""
        self._expire()
        monotonic, now = self._clock.monotonic(), self._clock.now()
        leases = sorted(
            (lease for lease in self._leases if request.device in {"", lease.part[0]}), key=lambda one: one.part
        )
        return LeasesResponse(parts=tuple(_held_part(lease, monotonic, now) for lease in leases))

    def end(self, request: EndLeasesRequest) -> LeasesResponse:
        """End all leases of a device, and return them."""
        response = self.held_parts(GetLeasesRequest(device=request.device))
        for lease, (issuer, by, _), _ in self._leases.end(request.device, request.issuer, self._clock.monotonic()):
            self._log("control.lease_ended", lease, f"is no longer held by {by} ({issuer}): {request.issuer} ended it")
            self._record("ended", lease, request.issuer, by)
        return response

    def _refusal(
        self, request: HoldRequest, holder: LeaseHolder, device: Device, part: DevicePart
    ) -> LeaseState | None:
        """Return the refusal of a code, of a value that the part does not take, or by rights or policies."""
        held = request.setting
        try:
            check_setting(device.id, part.part, held.capability, held.value.plain())
        except RefusedError as exc:
            return self._refuse(request, f"{exc.what}: {exc.reason}", "device")
        if (shown := without_codes((held,), device, part)) != (held,):
            return self._refuse(
                request.model_copy(update={"setting": shown[0]}), "a code is given once and cannot be held"
            )
        first = _command_of((device.id, part.id), held, request.issuer, holder)
        refused = self._executor.preview(first, device, part)
        return None if refused is None else self._refuse(request, refused.reason, refused.policy)

    def _begin(self, request: HoldRequest, holder: LeaseHolder) -> Lease | str:
        """Return the lease of a new holder, or the reason of its refusal."""
        capability, value = request.setting.capability, request.setting.value.plain()
        if not request.by.strip():
            return "a holder needs a name"
        if capability in MOMENTARY or value in {STOPPED, None}:
            return f"{capability} {value_text(value)} cannot be held, because it does not last"
        self._expire()
        now, key = self._clock.monotonic(), _key(request)
        if request.yields_to_persons:  # its value changes without a moment in which nobody sees a person's command
            if outranked := self._leases.outranked(key, now):
                return outranked
            self._release(key)
        lease = self._leases.hold((request.device, request.part), capability, value, key, holder, now)
        self._changed.set()
        return lease

    async def _command(self, lease: Lease, key: HolderKey, holder: LeaseHolder) -> Outcome | None:
        """Send the held value for one holder at a time; return None if the lease is over or outranked."""
        async with lease.lock:
            if not lease.holders or self._clock.monotonic() < lease.hand_until:
                return None
            request = _command_of(lease.part, lease.setting, key[0], holder)
            lease.outcome = outcome = await self._executor.perform(request)
            now = self._clock.monotonic()
            if now < lease.hand_until:
                pass  # stopped meanwhile
            elif isinstance(outcome, Contradicted) and lease.held is not None and lease.held.is_by_hand:
                self._leases.outrank(lease, outcome.saw, now)
            elif not outcome.succeeded:
                lease.again_at = now + _REPEATED_AFTER_S
            else:
                self._hand_back(lease)
        self._changed.set()
        return outcome

    def _on_report(self, lease: Lease, value: PlainValue, attribution: Attribution | None) -> None:
        """Handle a report of the held value, or of another one and its cause, unless the outcome of a command will."""
        now, saw = self._clock.monotonic(), f"{lease.capability} is {value_text(value)}"
        if lease.lock.locked() or lease.yielded_to or (attribution is not None and now < lease.hand_until):
            return
        if attribution is None:
            self._hand_back(lease)
        elif attribution.is_hand:
            self._leases.outrank(lease, saw, now)
        else:  # the device itself, which may refuse if it went back at once, or a command to a group
            lease.again_at = now + _REPEATED_AFTER_S if attribution.role is ReportRole.UNDONE else now
            self._log("control.held_again", lease, f"is held {lease.held_value}, but {saw}: it is commanded again")
        self._changed.set()

    def _expire(self) -> None:
        for lease, (issuer, _, _), holder in self._leases.expire(self._clock.monotonic()):
            self._record("expired", lease, issuer, holder.by)
            self._log("control.expired", lease, f"is no longer held {lease.held_value} by {holder.by}: time is over")

    def _release(self, key: HolderKey) -> Lease | None:
        lease = self._leases.release(key)
        if lease is not None:
            self._record("released", lease, key[0], key[1])
        return lease

    def _refuse(self, request: HoldRequest, reason: str, policy: str = LEASE_POLICY) -> LeaseState:
        self._node.log.info(
            "control.lease_refused",
            message=f"{request.device} is not held for {request.by} ({request.issuer}): {reason}",
            device=request.device,
        )
        self._journal.hold_denied(request, policy, reason)
        return LeaseState(held=False, outcome=Refused(policy, reason))

    def _on_outranked(self, lease: Lease) -> None:
        self._log("control.hand", lease, f"is held {lease.held_value}, but outranked: {lease.saw}")
        self._record("outranked", lease, lease.yielded_to, lease.saw)

    def _hand_back(self, lease: Lease) -> None:
        if lease.hand_back():
            self._record("handed_back", lease)

    def _record(
        self, step: LeaseStep, lease: Lease, issuer: str = "", text: str = "", trigger: Trigger = NO_TRIGGER
    ) -> None:
        self._journal.lease(step, lease.part, lease.setting, issuer, text, trigger)

    def _log(self, event: str, lease: Lease, text: str) -> None:
        self._node.log.info(event, message=f"{target_of(*lease.part)} {text}", device=lease.part[0])


def _command_of(place: tuple[str, str], held: Setting, issuer: str, holder: LeaseHolder) -> CommandRequest:
    device, part = place
    trigger = Trigger(kind="lease", text=holder.text[:_MAX_TEXT_CHARACTERS])
    return CommandRequest(
        device=device,
        part=part,
        settings=(held,),
        transition=holder.transition,
        issuer=issuer,
        scope=holder.scope,
        trigger=trigger,
    )


def _key(request: HoldRequest | HolderRequest) -> HolderKey:
    return request.issuer, request.by, request.lease


def _held_part(lease: Lease, monotonic: float, now: float) -> HeldPart:
    """Return *lease* at *monotonic* seconds, which is *now* in seconds since the Unix epoch."""

    def time(at: float) -> Time:
        return Time.from_seconds(now + at - monotonic)

    device, part = lease.part
    is_outranked = monotonic < lease.hand_until
    return HeldPart(
        device=device,
        part=part,
        setting=lease.setting,
        holders=tuple(
            HolderOfPart(
                by=holder.by,
                issuer=issuer,
                until=Time(sec=0, nanosec=0) if holder.is_open_ended else time(holder.deadline),
                trigger=holder.trigger,
            )
            for (issuer, _, _), holder in lease.holders.items()
        ),
        outranked_until=time(lease.hand_until) if is_outranked else Time(sec=0, nanosec=0),
        saw=lease.saw if is_outranked else "",
    )
