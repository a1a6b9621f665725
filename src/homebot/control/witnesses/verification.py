"""Witnesses of commands: sensors that see whether a device did what it reports."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import Final, TypeAlias, final

import anyio

from homebot.control.command import IssuedCommand
from homebot.control.learnt_persistence import LearntPersistence
from homebot.control.sending import OpenCommand
from homebot.control.settings import ControlSettings
from homebot.control.witnesses.command_watch import CommandWatch, watch_of
from homebot.control.witnesses.disbelief import Disbelief
from homebot.control.witnesses.finding import Finding
from homebot.control.witnesses.home_state import HomeState
from homebot.control.witnesses.home_watch import HomeWatch
from homebot.control.witnesses.learning import Trusted, WitnessLearning
from homebot.control.witnesses.sensor_findings import SensorFinding, patience, sees
from homebot.control.witnesses.sensors import Sensor
from homebot.devices.outcomes import Confirmed, Evidence, NoAnswer, Outcome
from homebot.graph import Node

__all__ = ["WitnessVerification"]

SEEN_LATE: Final = "control.seen_late"

_Wait: TypeAlias = Callable[[float], Awaitable[None]]


@final
class WitnessVerification:
    """Asks sensors about commands, and learns which of them can tell.

    Args:
        node: The node that follows them.
        settings: The sensors that the owner names, and for how long at most they are waited for.
        persistence: Keeps what is learnt over a restart.

    Attributes:
        doubted: The parts that are not believed; mostly none, and then nobody asks further.
    """

    def __init__(self, node: Node, settings: ControlSettings, persistence: LearntPersistence) -> None:
        self._clock = node.graph.clock
        self._home = HomeWatch(node, settings.named_witnesses, settings.timeout)
        self._node = node
        self._persistence = persistence
        self._learning = WitnessLearning(
            node, self._home, settings.timeout, persistence.keeper("witness"), self._note_seen_late
        )
        persistence.add("witness", self._learning)
        self._disbelief = Disbelief(node, self._home, self._learning, persistence.keeper("disproof"))
        persistence.add("disproof", self._disbelief)
        self.doubted = self._disbelief.parts
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

    @property
    def are_none(self) -> bool:
        """True if no sensor can tell of any command, and every device is believed: there is nothing to ask for then."""
        return not self.doubted and not self._home.sensors.ids

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
        home, place, disbelief = self._home, command.place, self._disbelief
        if self.doubted:
            disbelief.note_command(command)
        if not home.sensors.ids:
            return None
        is_at_rest = home.activity.begin(command.id, place)
        self._learning.stop(place)
        if not is_at_rest or not (sensors := home.sensors.candidates(command)):
            return None
        watch = watch_of(command, sensors, disbelief.strength(command), self._clock.monotonic(), wake)
        if watch is not None:
            disbelief.resume(watch)
            home.add(watch)
        return watch

    def end(self, command: IssuedCommand) -> None:
        """Note that *command* is over."""
        if self.doubted:
            self._disbelief.note_command(command)
        if command.id in self._home.activity.commands:
            self._home.activity.end(command.id, self._clock.monotonic())
            self._home.discard(command.id)

    def disproves(self, command: IssuedCommand) -> bool:
        """Return whether a witness saw that the last command for the same had no effect, whatever the part reports."""
        return bool(self.doubted) and self._disbelief.covers(command)

    async def believe(self, device: str) -> tuple[str, ...]:
        """Forget that *device* was not believed, as its owner says; return the names of its witnesses."""
        await self._persistence.load()
        return self._disbelief.believe_device(device)

    def notes(self) -> tuple[str, ...]:
        """Return a note on the devices that are not believed, for people."""
        return self._disbelief.notes()

    def note_text(self, command: IssuedCommand) -> None:
        """Note that *command* is sent as a text."""
        self._disbelief.note_command(command)

    async def verify(self, watch: CommandWatch | None, pending: OpenCommand, outcome: Outcome, wait: _Wait) -> Outcome:
        """Return *outcome*, or what a trusted sensor knows better; waits for that sensor.

        Args:
            watch: What :meth:`begin` returned.
            pending: The command, which may be superseded or taken back meanwhile.
            outcome: Its outcome by what the device reported.
            wait: Waits until something changed, for so many seconds at most.
        """
        if watch is not None:
            outcome = await self._ask(watch, pending, outcome, wait)
        return await self._disbelief.judge(pending.command, outcome)

    async def _ask(self, watch: CommandWatch, pending: OpenCommand, outcome: Outcome, wait: _Wait) -> Outcome:
        """Return *outcome*, or what a trusted sensor tells."""
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
        findings = await self._judge(watch, trusted)
        found = {one.finding: one for one in reversed(findings)}
        is_doubted = self._disbelief.concerns(watch.command.place)
        if is_confirmed and (Finding.SAW in found or not (Finding.NOTHING in found or is_doubted)):
            self._learning.watch(watch)
        if Finding.SAW in found:
            return self._confirmed(watch, outcome, found[Finding.SAW])
        if is_confirmed and Finding.NOTHING in found and (not is_doubted or self._disbelief.covers(watch.command)):
            return await self._contradicted(watch, found[Finding.NOTHING], outcome)
        if is_confirmed:
            self._note_stuck(findings)
        return outcome

    async def _wait(self, watch: CommandWatch, pending: OpenCommand, trusted: list[Trusted], wait: _Wait) -> None:
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
        self._disbelief.believe(watch.command.place)
        reported = outcome.latency if isinstance(outcome, Confirmed) else 0.0
        latency = max(reported, saw.seen_at - watch.given)
        return Confirmed(latency, Evidence.WITNESSED, saw.sensor.device.name, command_id=watch.command.id)

    async def _contradicted(self, watch: CommandWatch, no: SensorFinding, outcome: Outcome) -> Outcome:
        contradicted = await self._disbelief.contradict(watch, no, outcome)
        if contradicted is not outcome:
            self._counts["commands_disproved"] += 1
            watch.is_contradicted = True
            self._learning.watch(watch)  # the effect may come later than ever
        return contradicted

    def _note_stuck(self, findings: Iterable[SensorFinding]) -> None:
        for one in findings:
            if one.is_in_doubt:
                self._disbelief.note_stuck(one.sensor)

    def _note_seen_late(self, watch: CommandWatch, sensor: Sensor) -> None:
        device = watch.command.device
        self._disbelief.believe(watch.command.place)
        text = f"{sensor.device.name} saw {device.name} obey after all, later than ever"
        self._node.log.info(SEEN_LATE, message=text, device=device.id, command=watch.command.id)
