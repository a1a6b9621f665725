"""Values before an identification, kept in a store until they are back: after its end, and after a kill of homebot."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final, final

import anyio

from homebot.command_words.undo_record import KnownStates, KnownValue, known_states
from homebot.devices.batch import perform_all
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.device import target_of
from homebot.devices.names import PERFORM_COMMAND
from homebot.devices.outcomes import NoAnswer, Outcome, Superseded
from homebot.devices.trigger import Trigger
from homebot.devices.value_comparison import fits
from homebot.errors import LinkError, ServiceError

if TYPE_CHECKING:
    from homebot.devices.device_lookup import DeviceLookup
    from homebot.features.identify.candidates import CandidatePart
    from homebot.graph import Node

LEFT = "identify.left"
PUT_BACK = "identify.put_back"

_MAX_WAIT_S: Final = 120.0
"""Seconds after which a command is given up, and repeated later."""

_FIRST: Final = 10.0
"""Seconds after a start in which devices report; a silent one is commanded then."""

_AGAIN: Final = 2.0
_SELDOM: Final = 60.0
_OLD: Final = 3600.0
"""Seconds after an identification in which values are put back: later, a person may have changed them since."""

_CAPABILITY, _BEFORE, _WANTED, _SET_AT = range(4)


@final
class SavedValues:
    """Puts values back that nothing else has changed since.

    Args:
        store: By run, the issuer and the values; kept across restarts.
        flush: Writes the store now; returns the problem, empty for none.
        began_at: The time before this homebot heard of any device; what is older is of an earlier one.
    """

    def __init__(
        self,
        node: Node,
        lookup: DeviceLookup,
        store: MutableMapping[str, Any],
        flush: Callable[[], Awaitable[str]],
        began_at: float,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._store = store
        self._flush = flush
        self._perform = node.create_client(PerformCommand, PERFORM_COMMAND)
        self._began_at = began_at
        self._running: set[str] = set()
        self._has_left = anyio.Event()
        if store:
            self._has_left.set()

    async def keep(
        self, run: str, by: str, issuer: str, scope: Sequence[str], candidates: Sequence[CandidatePart]
    ) -> None:
        """Keep the values that *candidates* have now, before the first change: of what is not yet back, those before.

        Raises:
            LinkError: They cannot be written.
        """
        at, values = self._clock.now(), dict[str, list[Any]]()
        states = await known_states(self._node, await self._lookup.devices())
        for candidate in candidates:
            target = target_of(*candidate.place)
            if (known := states.get((*candidate.place, candidate.capability))) is not None:
                candidate.before = candidate.wanted = known.state.value.plain()
            values[target] = kept = [candidate.capability, candidate.before, candidate.wanted, candidate.set_at]
            for left in (saved["values"] for saved in self._store.values()):
                if target in left and left[target][_CAPABILITY] == candidate.capability:
                    candidate.before = kept[_BEFORE] = left.pop(target)[_BEFORE]
        self._store[run] = {"by": by, "issuer": issuer, "scope": [*scope], "at": at, "values": values}
        self._running.add(run)
        if problem := await self._flush():
            del self._store[run]
            raise LinkError(f"nothing was changed, as the values to put back cannot be kept: {problem}")

    async def save_again(self, run: str, candidate: CandidatePart) -> None:
        """Keep the value that a person gave *candidate* before its first change."""
        known = (await known_states(self._node, await self._lookup.devices())).get(
            (*candidate.place, candidate.capability)
        )
        kept = self._store[run]["values"].get(target_of(*candidate.place))
        if known is not None and kept is not None:
            candidate.before = candidate.wanted = kept[_BEFORE] = kept[_WANTED] = known.state.value.plain()
            await self._flush()

    def command(self, run: str, candidate: CandidatePart) -> None:
        """Record that *candidate* is given the value that it wants, unless its value is forgotten."""
        if kept := self._store[run]["values"].get(target_of(*candidate.place)):
            kept[_WANTED], kept[_SET_AT] = candidate.wanted, candidate.set_at

    async def forget(self, run: str, target: str) -> None:
        """Forget the value of what a person changes."""
        if self._store.get(run, {"values": {}})["values"].pop(target, None):
            await self._flush()

    async def leave_changed(self, run: str, candidate: CandidatePart) -> bool:
        """Forget a value if a person has changed it; return whether one has."""
        states, target = await known_states(self._node, await self._lookup.devices()), target_of(*candidate.place)
        kept = self._store[run]["values"].get(target)
        if kept and not _is_foreign(
            kept, states.get((*candidate.place, candidate.capability)), self._store[run]["issuer"]
        ):
            return False
        await self.forget(run, target)
        return True

    async def end(self, run: str) -> None:
        """Put the values of a run back; what cannot be now, or not before it is cancelled, is tried again."""
        try:
            with suppress(ServiceError):
                await self._put_back(run)
            await self._flush()
        finally:
            self._running.discard(run)
            if run in self._store:
                self._has_left.set()

    def left(self, run: str) -> str:
        """Return what is not as it was before a run, for people; empty for nothing."""
        values = self._store.get(run, {}).get("values", {})
        return f"{', '.join(values)} not yet as before, but homebot sees to it" if values else ""

    async def run(self) -> None:
        """Put back what is left of earlier runs, until cancelled."""
        while True:
            await self._has_left.wait()
            self._has_left, pause = anyio.Event(), _AGAIN
            while left := [run_id for run_id in self._store if run_id not in self._running]:
                for run in left:
                    with suppress(ServiceError):
                        await self._put_back(run)
                await self._flush()
                await anyio.sleep(pause)
                pause = min(2 * pause, _SELDOM)

    async def _put_back(self, run: str) -> None:
        kept = self._store[run]
        values: dict[str, list[Any]] = kept["values"]
        if values and kept["at"] + _OLD < self._clock.now():
            message = f"{', '.join(values)} may still be as {kept['by']} left them: that was long ago"
            self._node.log.warning(LEFT, message=message)
            values.clear()
        due = self._due(kept["issuer"], values, await known_states(self._node, await self._lookup.devices()))
        end = "was cut off by the end of homebot" if kept["at"] < self._began_at else "ended"
        requests = [
            CommandRequest(
                device=target.partition("#")[0],
                part=target.partition("#")[2],
                settings=(Setting.of(values[target][_CAPABILITY], values[target][_BEFORE]),),
                issuer=kept["issuer"],
                scope=tuple(kept["scope"]),
                trigger=Trigger(kind="end", text=f"{kept['by']} {end}"),
            )
            for target in due
        ]
        for target in due:
            values[target][_WANTED], values[target][_SET_AT] = values[target][_BEFORE], self._clock.now()
        outcomes = await perform_all(self._outcome, requests)
        for target, outcome in zip(due, outcomes, strict=True):
            if outcome.succeeded or isinstance(outcome, Superseded):  # a newer command is wanted now
                values.pop(target, None)
            else:
                text = f"{target} is not yet as before {kept['by']}: {outcome.text}; it is tried again"
                self._node.log.warning(PUT_BACK, message=text)
        if not values:
            del self._store[run]

    def _due(self, issuer: str, values: dict[str, list[Any]], states: KnownStates) -> list[str]:
        """Return the values to command now; forget those that are back, and those that a person changed."""
        due = []
        for target, kept in tuple(values.items()):
            device, _, part = target.partition("#")
            known = states.get((device, part, kept[_CAPABILITY]))
            state = None if known is None else known.state
            is_back = state is not None and fits(kept[_CAPABILITY], kept[_BEFORE], state.value.plain())
            if kept[_SET_AT] < self._began_at:  # of an earlier homebot, which may have known less than the device
                has_told = state is not None and state.told_at.to_seconds() >= self._began_at
                if not has_told and self._clock.now() < self._began_at + _FIRST:
                    continue
                is_done = has_told and is_back
            else:
                is_done = (is_back and kept[_WANTED] == kept[_BEFORE]) or _is_foreign(kept, known, issuer)
            if is_done:
                del values[target]
            elif state is not None:
                due.append(target)
        return due

    async def _outcome(self, request: CommandRequest) -> Outcome:
        try:
            return await self._perform.call(request, timeout=_MAX_WAIT_S)
        except ServiceError as exc:
            return NoAnswer(0.0, str(exc))


def _is_foreign(kept: Sequence[Any], known: KnownValue | None, issuer: str) -> bool:
    """Return whether something else than *issuer* has changed a value since it was commanded."""
    if known is None or fits(kept[_CAPABILITY], kept[_WANTED], known.state.value.plain()):
        return False
    is_later: bool = known.state.since.to_seconds() > kept[_SET_AT]
    if known.cause is None or not is_later:
        return is_later
    return known.cause.may_be_person or known.cause.issuer not in {"", issuer}
