"""Disbelief of devices that a witness contradicted: what they report counts for nothing until a witness agrees."""

from __future__ import annotations

from collections import OrderedDict
from typing import Final, final

from homebot.control.command import IssuedCommand
from homebot.control.learnt_record import KeepLearnt
from homebot.control.witnesses.activity import Place
from homebot.control.witnesses.command_watch import CommandWatch, wanted_strength
from homebot.control.witnesses.disproof import Disproof, disproof_name, disproof_record, read_disproof
from homebot.control.witnesses.effect import seen_by, strength_of
from homebot.control.witnesses.finding import QUIET
from homebot.control.witnesses.home_state import HomeState
from homebot.control.witnesses.home_watch import HomeWatch
from homebot.control.witnesses.learning import WitnessLearning
from homebot.control.witnesses.sensor_findings import SensorFinding
from homebot.control.witnesses.sensors import Sensor
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, Outcome
from homebot.devices.value import PlainValue
from homebot.graph import Node

__all__ = ["Disbelief"]

STUCK: Final = "control.witness_stuck"
FORGOTTEN: Final = "control.witness_forgotten"

_MOST: Final = 1000
"""Parts that are not believed; beyond, the longest known is believed again."""

_MOST_NAMED: Final = 5

_MOST_UNHEARD: Final = 4
"""Commands that a sensor may contradict without reporting anything at all; with one more it is taken to be dead."""

_EFFECT: Final = 60.0
"""Seconds after a command in which a change of its part is taken for its effect, and for no person's."""


@final
class Disbelief:
    """Remembers what witnesses contradicted.

    A part is believed again when a witness sees it obey, when it reports what was not believed without a command, and
    when its witness cannot be asked any more: it is gone, unreachable, stale, forbidden, stuck or taken to be dead.

    Args:
        node: The node that tells which sensors are no witnesses any more.
        home: The sensors.
        learning: What is known of them.
        keep: Keeps what is not believed over a restart.

    Attributes:
        parts: What is known of each part that is not believed.
    """

    def __init__(self, node: Node, home: HomeWatch, learning: WitnessLearning, keep: KeepLearnt) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._home = home
        self._learning = learning
        self._keep = keep
        self.parts: OrderedDict[Place, Disproof] = OrderedDict()
        home.on_change = self._take_change

    def concerns(self, place: Place) -> bool:
        """Return whether a witness saw that a part is not as it reported."""
        return place in self.parts

    def covers(self, command: IssuedCommand) -> bool:
        """Return whether a report of what *command* wants is not believed."""
        return self._covering(command) is not None

    def strength(self, command: IssuedCommand) -> float | None:
        """Return how strong the part of *command* is where its report is not believed; None where it is."""
        disproof = self._covering(command)
        return None if disproof is None else disproof.before

    def note_command(self, command: IssuedCommand) -> None:
        """Note that *command* is given, by whatever way, or is over: what changes now is its effect."""
        if (disproof := self.parts.get(command.place)) is not None:
            disproof.commanded_at = self._clock.monotonic()

    def resume(self, watch: CommandWatch) -> None:
        """Let *watch* begin where that of the contradicted command did, if that was a moment ago.

        So soon after a command no sensor rests, but what it shows since the first one tells as much.
        """
        disproof = self._covering(watch.command)
        first = None if disproof is None else disproof.watch
        if first is not None and watch.began - first.began <= QUIET:
            watch.began = first.began
            watch.marks = {one: mark for one, mark in first.marks.items() if one in watch.marks}

    def believe(self, place: Place) -> None:
        """Forget that a part was not believed."""
        if self.parts.pop(place, None) is not None:
            self._keep(disproof_name(place), "", "")

    def believe_device(self, device: str) -> tuple[str, ...]:
        """Forget that parts of *device* were not believed; return the names of their witnesses."""
        named = {place: disproof.name for place, disproof in self.parts.items() if place[0] == device}
        for place in named:
            self.believe(place)
        return tuple(sorted(set(named.values())))

    def notes(self) -> tuple[str, ...]:
        """Return a note on the devices that are not believed, for people."""
        if not self.parts:
            return ()
        found = sorted({f"{device} ({disproof.name})" for (device, _), disproof in self.parts.items()})
        named = ", ".join(found[:_MOST_NAMED]) + (", …" if len(found) > _MOST_NAMED else "")
        return (
            f"contradicted by a sensor, and not believed until it sees them obey, or you say so "
            f"(`homebot believe DEVICE`): {named}",
        )

    async def contradict(self, watch: CommandWatch, finding: SensorFinding, outcome: Outcome) -> Outcome:
        """Return the outcome of a command of which a witness saw nothing, though the device reports it.

        Args:
            watch: The command.
            finding: What the witness tells.
            outcome: The outcome by the report, which is returned where the witness is taken to be dead.
        """
        command, sensor = watch.command, finding.sensor
        disproof = self.parts.get(command.place)
        now = self._clock.now()
        if disproof is None or disproof.sensor != sensor.place:
            disproof = Disproof(watch.before, sensor.place, sensor.device.name, now, int(finding.is_by_silence))
        elif not await self._counts(disproof):
            return outcome
        disproof.before, disproof.reported = watch.before, set(command.settings)
        if disproof.watch is None or disproof.watch.began != watch.began:
            disproof.watch = watch
        sensor.accused = (command.target, sensor.history.count)
        self._put(command, disproof)
        return Contradicted(f"{disproof.name} measured no change", disproof.name, command_id=command.id)

    async def judge(self, command: IssuedCommand, outcome: Outcome) -> Outcome:
        """Return *outcome*, or that it is contradicted, where its report is not believed and no sensor can tell now."""
        disproof = self._covering(command)
        if disproof is None or not isinstance(outcome, Confirmed) or outcome.evidence is Evidence.WITNESSED:
            return outcome
        at = await self._home.state_of({disproof.sensor[0]})
        if not self._can_be_asked(command, disproof, at):
            self.believe(command.place)
            return outcome
        if not await self._counts(disproof):
            return outcome
        self._put(command, disproof)
        text = f"{disproof.name} measured no change before, and cannot tell now"
        return Contradicted(text, disproof.name, command_id=command.id)

    def note_stuck(self, sensor: Sensor) -> None:
        """Note that *sensor* would contradict a second part without having moved since it contradicted the first."""
        if sensor.stuck_at == sensor.history.count:
            return
        sensor.stuck_at = sensor.history.count
        self._believe_all(sensor.place)
        name, capability = sensor.device.name, sensor.capability
        text = f"{name} measured no change of two devices: it is no witness until its {capability} changes"
        self._node.log.warning(STUCK, message=text, sensor=sensor.device.id)

    def restore(self, name: str, record: str) -> None:
        """Take over what an earlier run did not believe.

        Raises:
            WireError: It cannot be read, or is of another version.
        """
        place, disproof = read_disproof(name, record)
        self.parts.setdefault(place, disproof)

    def _covering(self, command: IssuedCommand) -> Disproof | None:
        disproof = self.parts.get(command.place)
        return disproof if disproof is not None and disproof.covers(wanted_strength(command)) else None

    def _put(self, command: IssuedCommand, disproof: Disproof) -> None:
        place = command.place
        self.parts[place] = disproof
        self.parts.move_to_end(place)
        disproof.commanded_at = self._clock.monotonic()
        self._keep(disproof_name(place), disproof_record(place, disproof), command.id)
        if len(self.parts) > _MOST:
            self.believe(next(iter(self.parts)))

    async def _counts(self, disproof: Disproof) -> bool:
        """Count one more command that is not believed; return False where the witness is taken to be dead by now."""
        at = await self._home.state_of({disproof.sensor[0]})
        since = at.now - (at.wall - disproof.counted_at)
        disproof.count(at.wall, is_heard=at.is_alive(disproof.sensor, since))
        if disproof.unheard <= _MOST_UNHEARD:
            return True
        self._learning.forget(disproof.sensor)
        self._believe_all(disproof.sensor)
        text = f"{disproof.name} reported nothing at all at {_MOST_UNHEARD} commands: it is no witness any more"
        self._node.log.warning(FORGOTTEN, message=text, sensor=disproof.sensor[0])
        return False

    def _can_be_asked(self, command: IssuedCommand, disproof: Disproof, at: HomeState) -> bool:
        """Return whether the witness is there, is still one, and may tell another time."""
        if not at.is_reachable(disproof.sensor) or not self._learning.is_trusted(command.target, disproof.sensor):
            return False
        sensor = self._home.sensors[disproof.sensor]  # not known yet right after a start
        return sensor is None or sensor in self._home.sensors.candidates(command)

    def _believe_all(self, sensor: tuple[str, str, str]) -> None:
        for place in [place for place, disproof in self.parts.items() if disproof.sensor == sensor]:
            self.believe(place)

    def _take_change(self, place: Place, capability: str, value: PlainValue) -> None:
        """Take in a change; one that no command explains, to what was not believed, is a person's doing."""
        disproof = self.parts.get(place)
        if disproof is None or not seen_by((capability,)):
            return
        is_first = capability not in disproof.reported
        disproof.reported.add(capability)
        if is_first or place in self._home.activity.commands.values():
            return
        if self._clock.monotonic() - disproof.commanded_at < _EFFECT:
            return
        if disproof.covers(strength_of({capability: value}, ())):
            self.believe(place)
