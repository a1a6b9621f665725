"""Witnesses of commands: sensors that see whether a device did what it reports."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Awaitable, Callable, Mapping
from typing import Final, TypeAlias, final

import anyio

from homebot.control.command import IssuedCommand
from homebot.control.learnt_persistence import LearntPersistence
from homebot.control.pending import PendingCommand
from homebot.control.settings import ControlSettings
from homebot.control.witnesses.activity import Place
from homebot.control.witnesses.command_watch import CommandWatch, wanted_strength, watch_of
from homebot.control.witnesses.finding import Finding
from homebot.control.witnesses.home_state import HomeState
from homebot.control.witnesses.home_watch import HomeWatch
from homebot.control.witnesses.learning import Trusted, WitnessLearning
from homebot.control.witnesses.sensor_findings import SensorFinding, patience, sees
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, NoAnswer, Outcome
from homebot.graph import Node

__all__ = ["WitnessVerification"]

_MOST_DISPROVED: Final = 1000
"""Parts that are known not to be as they report; beyond, the longest known is believed again."""

_HALF: Final = 50.0

_Wait: TypeAlias = Callable[[float], Awaitable[None]]


@final
class WitnessVerification:
    """Asks sensors about commands, and learns which of them can tell.

    Args:
        node: The node that follows them.
        settings: The sensors that the owner names, and for how long at most they are waited for.
        persistence: Keeps what is learnt over a restart.
    """

    def __init__(self, node: Node, settings: ControlSettings, persistence: LearntPersistence) -> None:
        self._clock = node.graph.clock
        self._home = HomeWatch(node, settings.named_witnesses, settings.timeout)
        self._learning = WitnessLearning(node, self._home, settings.timeout, persistence.keeper("witness"))
        persistence.add("witness", self._learning)
        self._disproved: OrderedDict[Place, float] = OrderedDict()
        self._counts = {"commands_witnessed": 0, "commands_disproved": 0}

    @property
    def counters(self) -> Mapping[str, Callable[[], int]]:
        """The functions that read each counter, by its name in the health of the node."""
        return {
            "commands_witnessed": lambda: self._counts["commands_witnessed"],
            "commands_disproved": lambda: self._counts["commands_disproved"],
            "witnesses_forgotten": lambda: self._learning.forgotten,
            "witnesses_not_learnt": lambda: self._learning.missed,
        }

    async def run(self) -> None:
        """Follow the sensors and learn, until cancelled."""
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._home.run)
            tasks.start_soon(self._learning.run)

    def begin(self, command: IssuedCommand, wake: Callable[[], None]) -> CommandWatch | None:
        """Note that *command* is on its way; return its watch, None where no sensor could see what it does.

        Args:
            command: The command; :meth:`end` must follow.
            wake: Called when one of its sensors tells something.
        """
        home, place = self._home, command.place
        if not home.sensors.ids:
            return None
        is_at_rest = home.activity.begin(command.id, place)
        self._learning.stop(place)
        if not is_at_rest or not (sensors := home.sensors.candidates(command)):
            return None
        watch = watch_of(command, sensors, self._disproved.get(place), self._clock.monotonic(), wake)
        if watch is not None:
            home.add(watch)
        return watch

    def end(self, command: IssuedCommand) -> None:
        """Note that *command* is over."""
        if command.id in self._home.activity.commands:
            self._home.activity.end(command.id, self._clock.monotonic())
            self._home.discard(command.id)

    def disproves(self, command: IssuedCommand) -> bool:
        """Return whether a witness saw that the last command for the same had no effect, whatever the part reports."""
        if not self._disproved:
            return False
        before, after = self._disproved.get(command.place), wanted_strength(command)
        return before is not None and after is not None and (after > before) is (before < _HALF)

    async def verify(self, watch: CommandWatch, pending: PendingCommand, outcome: Outcome, wait: _Wait) -> Outcome:
        """Return *outcome*, or what a trusted sensor knows better; waits for that sensor.

        Args:
            watch: What :meth:`begin` returned.
            pending: The command, which may be superseded or taken back meanwhile.
            outcome: Its outcome by what the device reported.
            wait: Waits until something changed, for so many seconds at most.
        """
        is_confirmed = isinstance(outcome, Confirmed)
        if not is_confirmed and (not isinstance(outcome, NoAnswer) or outcome.reason):
            return outcome
        watch.reported = self._clock.monotonic()
        trusted = self._learning.trusted(watch)
        if is_confirmed and trusted:
            await self._wait(watch, pending, trusted, wait)
            newest = pending.outcome(self._clock.monotonic())
            if not isinstance(newest, Confirmed):
                return newest
        found = {one.finding: one for one in reversed(await self._judge(watch, trusted))}
        if is_confirmed and (Finding.SAW in found or Finding.NOTHING not in found):
            self._learning.watch(watch)
        if Finding.SAW in found:
            return self._confirmed(watch, outcome, found[Finding.SAW])
        if is_confirmed and Finding.NOTHING in found:
            return self._contradicted(watch, found[Finding.NOTHING])
        return outcome

    async def _wait(self, watch: CommandWatch, pending: PendingCommand, trusted: list[Trusted], wait: _Wait) -> None:
        """Wait until a sensor saw the effect, or until the last has had its time."""
        effect, home = watch.effect(), await self._home.state(watch)
        if effect is None:
            return
        until = watch.reported + max(patience(watch, *one, effect, home) for one in trusted)
        now = self._clock.monotonic()
        while isinstance(pending.outcome(now), Confirmed):
            at = HomeState(self._home.activity, home.devices, now, self._clock.now())
            if now >= until or any(sees(watch, *one, effect, at).finding is Finding.SAW for one in trusted):
                return
            await wait(until - now)
            now = self._clock.monotonic()

    async def _judge(self, watch: CommandWatch, trusted: list[Trusted]) -> list[SensorFinding]:
        """Return what the trusted sensors tell."""
        if not trusted:
            return []
        home = await self._home.state(watch)
        effect = watch.effect(home.devices.get(watch.command.device.id))
        return [] if effect is None else [sees(watch, *one, effect, home) for one in trusted]

    def _confirmed(self, watch: CommandWatch, outcome: Outcome, saw: SensorFinding) -> Outcome:
        self._counts["commands_witnessed"] += 1
        self._disproved.pop(watch.command.place, None)
        reported = outcome.latency if isinstance(outcome, Confirmed) else 0.0
        latency = max(reported, saw.seen_at - watch.began)
        return Confirmed(latency, Evidence.WITNESSED, saw.sensor.device.name, command_id=watch.command.id)

    def _contradicted(self, watch: CommandWatch, no: SensorFinding) -> Outcome:
        self._counts["commands_disproved"] += 1
        place, sensor = watch.command.place, no.sensor
        sensor.accused = (watch.command.target, sensor.history.count)
        self._disproved[place] = watch.before
        self._disproved.move_to_end(place)
        if len(self._disproved) > _MOST_DISPROVED:
            self._disproved.popitem(last=False)
        name = sensor.device.name
        return Contradicted(f"{name} measured no change", name, command_id=watch.command.id)
