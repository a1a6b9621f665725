"""One identification: the candidates change, each in its own code, and a sensor looks when all have settled.

A look takes a second, and begins at least 0.8 s after the last change that a candidate reported, so that nothing ever
flashes three times in a second, which is dangerous for people with photosensitive epilepsy. Lamps may report at once
and then fade for seconds: how long is seen when all turn bright together. Each value is held by a lease that yields to
persons, so that nothing else changes it meanwhile. One that does not obey, or that a person changes, drops out.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from math import inf
from random import Random
from typing import TYPE_CHECKING, Final, final

import anyio

from homebot.command_words.undo_record import plain_states
from homebot.devices.command_messages import Setting
from homebot.devices.device import target_of
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.lease_messages import HolderRequest, HoldPart, HoldRequest, ReleaseLease, RenewLease
from homebot.devices.names import HOLD_PART, JOURNAL_ENTRIES, RELEASE_LEASE, RENEW_LEASE
from homebot.devices.value import PlainValue
from homebot.errors import ServiceError, UsageError
from homebot.features.identify.belief import Seen
from homebot.features.identify.inquiry import STILL_LOOKS, Inquiry
from homebot.features.identify.messages import CandidateState, IdentifyDeviceFeedback, IdentifyDeviceGoal, LookRecord

if TYPE_CHECKING:
    from homebot.devices.device_lookup import DeviceLookup
    from homebot.features.identify.candidates import CandidatePart
    from homebot.features.identify.saved_values import SavedValues
    from homebot.features.identify.sight import Sight
    from homebot.graph import Node

_FADES: Final = 6.0
"""Seconds after which a look begins though a candidate still reports changes, as one with an effect does for ever."""

_ENTRIES: Final = 1000
"""Entries of the journal that wait at most."""

_FADING: Final = frozenset({"on_off", "level", "position", "fan_speed"})

_COMMAND: Final = 120.0
"""Seconds after which a device that has not answered takes part no more: blinds are slow."""


@final
class Identification:
    """Finds the candidate in view.

    Args:
        run: Its id.
        by: Its name for people, as the holder of the leases.
        check: Called before each change; raises `RefusedError` when nothing may change any more.
        on_look: Called after each look.

    Attributes:
        looks: The looks so far.
    """

    def __init__(
        self,
        node: Node,
        run: str,
        by: str,
        goal: IdentifyDeviceGoal,
        candidates: Sequence[CandidatePart],
        lookup: DeviceLookup,
        sight: Sight,
        kept: SavedValues,
        random: Random,
        check: Callable[[], Awaitable[None]],
        on_look: Callable[[IdentifyDeviceFeedback], None],
    ) -> None:
        self._run_id, self._by = run, by
        self._goal, self._candidates = goal, candidates
        self._clock = node.graph.clock
        self._lookup, self._sight, self._kept = lookup, sight, kept
        self._check_all, self._on_look = check, on_look
        self._inquiry = Inquiry(len(candidates), goal.least_effect, goal.sure, random)
        self._hold = node.create_client(HoldPart, HOLD_PART)
        self._renew = node.create_client(RenewLease, RENEW_LEASE)
        self._release = node.create_client(ReleaseLease, RELEASE_LEASE)
        self._entries = node.create_subscription(JournalEntry, JOURNAL_ENTRIES, self._on_entry, _ENTRIES)
        self._commands: dict[str, tuple[str, str]] = {}  # those without an outcome: the places by id
        self._has_ended = anyio.Event()
        self._began = self._last_at = self._clock.monotonic()
        self.looks: list[LookRecord] = []

    @property
    def none(self) -> float:
        """The probability of none of the candidates."""
        belief = self._inquiry.belief
        return 1 / (len(self._candidates) + 1) if belief is None else belief.none

    @property
    def trouble(self) -> str:
        """The reason for which no look decides; empty if there is none."""
        if self._sight.trouble:
            return self._sight.trouble
        if not self._inquiry.follows:
            return "what is seen changes by itself, and does not follow the candidates; look when the light is steady"
        if rivals := [self._candidates[number].name for number in self._inquiry.rivals]:
            return f"{' and '.join(rivals)} change what is seen alike, as one device does, or two in view; come nearer"
        return ""

    @property
    def largest(self) -> float:
        """The effect that is excluded for each candidate, in the unit of the sensor."""
        return inf if self._inquiry.belief is None else self._inquiry.belief.largest()

    def states(self) -> tuple[CandidateState, ...]:
        """Return the states of the candidates."""
        return tuple(map(self._state, range(len(self._candidates)), self._candidates))

    async def watch(self) -> None:
        """Look before anything changes.

        Raises:
            UsageError: The sensor sees nothing.
        """
        for _ in range(STILL_LOOKS if self._sight.is_prompt else 1):
            self._inquiry.add(await self._look())

    async def run(self) -> tuple[bool, CandidatePart | None]:
        """Return whether it is sure, and the candidate; None for none of them.

        Raises:
            UsageError: The sensor sees nothing, or no candidate obeys.
            RefusedError: Nothing may change any more.
        """
        self._began, inquiry = self._clock.monotonic(), self._inquiry
        for code in inquiry.codes():
            seen = await (self._look() if code is None else self._look_at(code))
            for number, candidate in enumerate(self._candidates):
                if candidate.problem:
                    inquiry.drop(number)
            inquiry.add(seen, self._sight.trouble)
            self.looks.append(
                LookRecord(
                    at=self._last_at - self._began, value=seen.value, deviation=seen.variance**0.5, levels=seen.levels
                )
            )
            self._on_look(IdentifyDeviceFeedback(look=self.looks[-1], none=self.none, candidates=self.states()))
            if self._clock.monotonic() >= self._began + self._goal.seconds:
                break
        is_sure, index = inquiry.is_sure, inquiry.found
        return is_sure, None if not is_sure or index is None else self._candidates[index]

    def close(self) -> None:
        """Leave the graph."""
        for entity in (self._hold, self._renew, self._release, self._entries):
            entity.close()

    async def end(self) -> None:
        """Release all leases, and put everything back."""
        for candidate in self._candidates:
            await self._release_lease(candidate)
        await self._kept.end(self._run_id)

    async def _look_at(self, code: Sequence[bool]) -> Seen:
        """Return what is seen once each candidate that still takes part is as *code* says, and has settled."""
        await self._check_all()
        async with anyio.create_task_group() as tasks:
            for candidate, is_bright in zip(self._candidates, code, strict=True):
                tasks.start_soon(self._set, candidate, candidate.bright if is_bright else candidate.dark)
        await self._settle()
        return await self._look()

    async def _look(self) -> Seen:
        while True:
            began = self._clock.monotonic()
            (value, variance), before = await self._sight.look(), self._taking_part()
            at = (began + self._clock.monotonic()) / 2
            for candidate in before:
                if candidate.lease:
                    await self._check(candidate)
            if self._taking_part() == before:
                return await self._seen(value, variance, at)

    async def _settle(self) -> None:
        """Wait until no candidate has reported a change for as long as one of its kind goes on changing."""
        parts = {candidate.place: candidate.settles + self._inquiry.fades_on for candidate in self._taking_part()}
        wait = max(parts.values())
        with anyio.move_on_after(_FADES + self._inquiry.fades_on):
            while wait > 0:
                await anyio.sleep(wait)
                states, now = plain_states(await self._lookup.devices()), self._clock.now()
                ends = (
                    state.since.to_seconds() + parts[device, part]
                    for (device, part, name), state in states.items()
                    if name in _FADING and (device, part) in parts
                )
                wait = max(ends, default=now) - now

    def _taking_part(self) -> list[CandidatePart]:
        candidates = [candidate for candidate in self._candidates if not candidate.problem]
        if not candidates:
            reasons = "; ".join(f"{candidate.name}: {candidate.problem}" for candidate in self._candidates)
            raise UsageError(f"no candidate takes part any more: {reasons}")
        return candidates

    async def _seen(self, value: float, variance: float, at: float) -> Seen:
        states = plain_states(await self._lookup.devices())
        known = [(candidate, states.get((*candidate.place, candidate.capability))) for candidate in self._candidates]
        levels = tuple(
            candidate.level_of(candidate.wanted if state is None else state.value.plain()) for candidate, state in known
        )
        middle = self._clock.now() - (self._clock.monotonic() - at)
        ages = tuple(inf if state is None else max(middle - state.since.to_seconds(), 0.0) for _, state in known)
        seconds, self._last_at = at - self._last_at, at
        return Seen(levels, value, variance, seconds, ages)

    async def _set(self, candidate: CandidatePart, value: PlainValue) -> None:
        """Hold *candidate* at *value*, if it takes part; it does not any more if it does not obey."""
        if candidate.problem or (candidate.lease and candidate.wanted == value):
            return
        if candidate.lease and not await self._check(candidate):
            return
        if not candidate.lease and candidate.place in self._commands.values():  # which a hold would supersede
            with anyio.move_on_after(_COMMAND):
                while candidate.place in self._commands.values():
                    await self._has_ended.wait()
            await self._kept.save_again(self._run_id, candidate)
        is_held, before = bool(candidate.lease), (candidate.wanted, candidate.set_at)
        candidate.wanted, candidate.set_at = value, self._clock.now()
        candidate.lease = candidate.lease or f"{self._run_id}-{self._candidates.index(candidate)}"
        self._kept.command(self._run_id, candidate)
        device, part = candidate.place
        request = HoldRequest(
            device=device,
            part=part,
            setting=Setting.of(candidate.capability, value),
            lease=candidate.lease,
            by=self._by,
            ttl=self._goal.seconds + _COMMAND,
            is_open_ended=True,
            yields_to_persons=True,
            transition=candidate.transition,
            issuer=self._goal.issuer,
            scope=self._goal.scope,
        )
        try:
            outcome = (await self._hold.call(request, timeout=_COMMAND, cancel_with_caller=True)).outcome
        except ServiceError as exc:
            await self._drop(candidate, str(exc))
        else:
            if not outcome.succeeded:
                if not outcome.was_sent:
                    candidate.wanted, candidate.set_at = before
                    self._kept.command(self._run_id, candidate)
                await self._drop(candidate, outcome.text)
            elif is_held and not outcome.was_sent:  # it was switched since the check
                await self._kept.forget(self._run_id, target_of(device, part))
                await self._drop(candidate, "it was changed meanwhile")

    async def _check(self, candidate: CandidatePart) -> bool:
        """Return whether *candidate* is still held as it was set; if not, it takes part no more."""
        state = await self._renew.call(self._holder(candidate))
        if state.held and state.outcome.succeeded:
            return True
        await self._drop(candidate, state.outcome.text)
        return False

    async def _drop(self, candidate: CandidatePart, problem: str) -> None:
        await self._release_lease(candidate)
        is_changed = await self._kept.leave_changed(self._run_id, candidate)
        candidate.problem = f"it was changed meanwhile: {problem}" if is_changed else problem

    async def _release_lease(self, candidate: CandidatePart) -> None:
        if candidate.lease:
            await self._release.call(self._holder(candidate))
            candidate.lease = ""

    async def _on_entry(self, entry: JournalEntry) -> None:
        """Leave a candidate as a person commands it, now, as homebot may be killed before the next look."""
        if entry.kind == "requested" and (entry.device, entry.part) in [
            candidate.place for candidate in self._candidates
        ]:
            self._commands[entry.command] = (entry.device, entry.part)
        elif entry.kind == "outcome":
            self._commands.pop(entry.command, None)
            self._has_ended.set()
            self._has_ended = anyio.Event()
        if entry.kind == "outranked" and entry.issuer:
            await self._kept.forget(self._run_id, target_of(entry.device, entry.part))

    def _holder(self, candidate: CandidatePart) -> HolderRequest:
        return HolderRequest(lease=candidate.lease, by=self._by, issuer=self._goal.issuer)

    def _state(self, number: int, candidate: CandidatePart) -> CandidateState:
        belief = self._inquiry.belief
        effect, deviation = (0.0, 0.0) if belief is None else belief.effect(number)
        device, part = candidate.place
        return CandidateState(
            device=device,
            part=part,
            name=candidate.name,
            probability=self.none if belief is None else belief.each[number],
            effect=effect,
            deviation=deviation,
            problem=candidate.problem,
        )
