"""Learning of which sensor sees what which part does, from commands that the device confirmed."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from typing import Final, TypeAlias, final

import anyio

from homebot.control.learnt_record import KeepLearnt
from homebot.control.witnesses.activity import Place
from homebot.control.witnesses.command_watch import CommandWatch
from homebot.control.witnesses.effect import Effect
from homebot.control.witnesses.home_watch import HomeWatch
from homebot.control.witnesses.saved_witness import SavedWitness, read_witness, witness_name, witness_record
from homebot.control.witnesses.sensor_findings import observed, was_silent
from homebot.control.witnesses.sensors import Sensor, SensorPlace
from homebot.control.witnesses.witness_record import Expected, Observation, WitnessRecord
from homebot.graph import Node
from homebot.timer_queue import TimerQueue

__all__ = ["Trusted", "WitnessLearning"]

LEARNT: Final = "control.witness_learnt"

_MOST_RECORDS: Final = 1000
_MOST_WATCHED: Final = 1000

_Key: TypeAlias = tuple[str, SensorPlace]

Trusted: TypeAlias = tuple[Sensor, WitnessRecord, Expected]
"""A sensor that is trusted, with its record and what it will see."""


@final
class WitnessLearning:
    """Compares, some seconds after each confirmed command, what its sensors did.

    Args:
        node: The node that tells what was learnt.
        home: The sensors.
        seconds: How long the sensors are watched after a report.
        keep: Keeps what is learnt over a restart.
        seen_late: Called with a command that was contradicted, when a sensor sees its effect after all.

    Attributes:
        forgotten: Pairs of a part and a sensor that were forgotten: 1,000 are kept, the longest unused goes first.
        missed: Confirmed commands from which nothing was learnt, since 1,000 were being watched.
    """

    def __init__(
        self,
        node: Node,
        home: HomeWatch,
        seconds: float,
        keep: KeepLearnt,
        seen_late: Callable[[CommandWatch, Sensor], None],
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._home = home
        self._seconds = seconds
        self._keep = keep
        self._seen_late = seen_late
        self._watched: dict[Place, CommandWatch] = {}
        self._deadlines: TimerQueue[Place, None] = TimerQueue()
        self._added = anyio.Event()
        self._records: OrderedDict[_Key, WitnessRecord] = OrderedDict()
        self.forgotten = 0
        self.missed = 0

    def trusted(self, watch: CommandWatch) -> list[Trusted]:
        """Return the sensors that will see the effect of a command in time."""
        effect = watch.effect()
        found: list[Trusted] = []
        for sensor in watch.marks if effect is not None else ():
            record = self._records.get((watch.command.target, sensor.place))
            expected = None if record is None or effect is None else record.expected(rises=effect.rises)
            if record is not None and expected is not None and expected.within <= self._seconds:
                found.append((sensor, record, expected))
        return found

    def is_trusted(self, target: str, sensor: SensorPlace) -> bool:
        """Return whether *sensor* sees what the part *target* does."""
        record = self._records.get((target, sensor))
        expected = None if record is None else record.expected(rises=True)
        return expected is not None and expected.within <= self._seconds

    def forget(self, sensor: SensorPlace) -> None:
        """Forget all that was learnt of *sensor*."""
        for key in [one for one in self._records if one[1] == sensor]:
            del self._records[key]
            self._keep(witness_name(*key), "", "")

    def watch(self, watch: CommandWatch) -> None:
        """Look again at a command that its device reported, when its sensors have had time; nobody waits for it."""
        place = watch.command.place
        if len(self._watched) >= _MOST_WATCHED:
            self.missed += 1
            return
        self._watched[place] = watch
        self._deadlines.set(place, watch.reported + self._seconds, None)
        self._added.set()

    def stop(self, place: Place) -> None:
        """Forget the last command to a part: there is a newer one."""
        if self._watched.pop(place, None) is not None:
            self._deadlines.discard(place)

    async def run(self) -> None:
        """Work until cancelled."""
        while True:
            while (due := self._deadlines.pop(self._clock.monotonic())) is not None:
                await self._learn(self._watched.pop(due[0]))
            following = self._deadlines.next()
            if following is None:
                self._added = anyio.Event()
                await self._added.wait()
            else:  # what is added meanwhile is due later
                await anyio.sleep(max(0.0, following - self._clock.monotonic()))

    async def _learn(self, watch: CommandWatch) -> None:
        at = await self._home.state(watch)
        effect = watch.effect(at.devices.get(watch.command.device.id))
        if effect is None:
            return
        for sensor in watch.marks:
            found = observed(watch, sensor, effect, at, self._seconds)
            known = self._records.get((watch.command.target, sensor.place))
            if watch.is_contradicted and (found is None or known is None or not known.is_usual(found)):
                continue
            if watch.is_contradicted:
                self._seen_late(watch, sensor)
            if found is not None:
                self._note(watch, sensor, effect, found)
            elif known is not None and was_silent(watch, sensor, known, effect, at):
                known.note_silence()
                self._save(watch, sensor, known)

    def _note(self, watch: CommandWatch, sensor: Sensor, effect: Effect, found: Observation) -> None:
        record = self._record((watch.command.target, sensor.place))
        was_trusted = record.expected(rises=effect.rises) is not None
        record.note(found)
        if not was_trusted and (expected := record.expected(rises=effect.rises)) is not None:
            self._tell(watch, sensor, expected)
        self._save(watch, sensor, record)

    def restore(self, name: str, record: str) -> None:
        """Take over what an earlier run learnt, which :meth:`_save` kept; the readings that it has are none of now.

        Raises:
            WireError: It cannot be read, or is of another version.
        """
        saved = read_witness(name, record)
        known = self._record((saved.target, saved.sensor))
        for one in saved.observations:
            known.note(one)
        known.seen_in_row = saved.seen_in_row
        ahead = self._clock.now() - self._clock.monotonic()
        steps = (
            (at - ahead, before, size) for at, before, size in saved.steps if at - ahead <= self._clock.monotonic()
        )
        self._home.sensors.remember(saved.sensor, steps, saved.levels)

    def _save(self, watch: CommandWatch, sensor: Sensor, record: WitnessRecord) -> None:
        target, resolution = watch.command.target, sensor.history.resolution
        ahead = self._clock.now() - self._clock.monotonic()
        steps = tuple((at + ahead, before, size) for at, before, size in resolution.steps)
        saved = SavedWitness(target, sensor.place, record.observations, record.seen_in_row, steps, resolution.levels)
        self._keep(witness_name(target, sensor.place), witness_record(saved), watch.command.id)

    def _record(self, key: _Key) -> WitnessRecord:
        record = self._records.setdefault(key, WitnessRecord())
        self._records.move_to_end(key)
        if len(self._records) > _MOST_RECORDS:
            forgotten, _ = self._records.popitem(last=False)
            self.forgotten += 1
            self._keep(witness_name(*forgotten), "", "")
        return record

    def _tell(self, watch: CommandWatch, sensor: Sensor, expected: Expected) -> None:
        device = watch.command.device
        text = (
            f"{sensor.device.name} sees {device.name}: its {sensor.capability} changes by {expected.least:g} or more"
            f" within {expected.slowest:.2g} s"
        )
        self._node.log.info(LEARNT, message=text, device=device.id, sensor=sensor.device.id)
