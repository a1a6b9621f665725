"""The node of the history: collects, stores and serves the values of all devices."""

import math
from datetime import tzinfo
from functools import partial
from pathlib import Path
from typing import Final, final

import anyio
from anyio.abc import TaskStatus

from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.devices.history_messages import CorrectHistory, ReadEnergy, ReadHistory
from homebot.devices.house_view import HouseView
from homebot.feature_context import FeatureContext
from homebot.features.history import CORRECT_HISTORY, FEATURE, HISTORY_FILE, READ_ENERGY, READ_HISTORY
from homebot.features.history.collector import Collector
from homebot.features.history.history_file import HistoryStore
from homebot.features.history.history_service import HistoryService
from homebot.features.history.settings import HistorySettings
from homebot.graph import Node
from homebot.support.counters import Severity
from homebot.support.isolation import run_as

_LOOK_EVERY: Final = 60.0
"""The longest time between two clock checks, in seconds: the clock may be set, or the computer may sleep."""

_LATE: Final = 60.0
"""Seconds by which the clock may differ from the elapsed time."""

_MANY: Final = 20_000
"""The number of values that are written before the batch is due."""

_LAST_CHANCE: Final = 5.0


async def record_history(house: FeatureContext) -> None:
    """Keep the history until cancelled, in a file or, in a run without files, in memory."""
    async with Node(house.graph, FEATURE.name) as node:
        settings = house.table("history") or HistorySettings()
        await run_as(node.full_name, HistoryKeeper(node, settings, house.file(HISTORY_FILE), house.zone).serve)


@final
class HistoryKeeper:
    """Keeps the history of a house.

    Args:
        path: The file; None for memory.
        zone: The time zone of the home; None for the computer's.
    """

    def __init__(
        self, node: Node, settings: HistorySettings, path: Path | None = None, zone: tzinfo | None = None
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._settings = settings
        self._store = HistoryStore(node, path, settings)
        self._collector = Collector(self._clock, settings.series, {}, {})
        self._service = HistoryService(node, self._store, zone)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Keep the history until cancelled."""
        create = self._node.create_service
        create(ReadHistory, READ_HISTORY.name, self._service.read, concurrent=True)
        create(CorrectHistory, CORRECT_HISTORY.name, self._service.correct)
        create(ReadEnergy, READ_ENERGY.name, self._service.energy, concurrent=True)
        create(GetHealth, "~/health", self.health)
        try:
            while (stored := await self._store.open()) is None:  # noqa: ASYNC110 - a disk tells nobody that it is back
                await anyio.sleep(math.inf if self._store.kept.is_unusable else _LOOK_EVERY)
            self._collector = Collector(self._clock, self._settings.series, stored.series, stored.last)
            self._store.file.write_rest = partial(self._store.write, self._collector)
            self._service.collector = self._collector
            house = HouseView.of(self._node)
            house.add(self._collector)
            task_status.started()
            await self._write_batches()
        finally:
            self._store.file.write_rest = None
            self._collector.close()
            with anyio.move_on_after(_LAST_CHANCE, shield=True):
                if self._service.collector is not None:
                    await self._store.write(self._collector)
                await self._store.kept.close()

    def health(self, _: HealthRequest) -> HealthResponse:
        """Return the counters of the history, and the problem of its file."""
        collector, file = self._collector, self._store.kept
        counts = {
            "history_series": len(collector.series),
            "history_left_out": collector.left_out,
            "history_folded": collector.folded,
        }
        losses = {"history_lost": collector.lost, "history_failures": file.failures}
        counted = (*Count.each(counts), *Count.each(losses, Severity.LOSS))
        return HealthResponse(counts=counted, troubles=(file.trouble,) if file.trouble else ())

    async def _write_batches(self) -> None:
        batch, clock, collector = self._settings.batch, self._clock, self._collector
        now, passed = clock.now(), clock.monotonic()
        due = _next(now, batch)
        while True:
            await anyio.sleep(min(max(due - now, 0.0), _LOOK_EVERY))
            before, now, passed_before, passed = now, clock.now(), passed, clock.monotonic()
            if abs((now - before) - (passed - passed_before)) > _LATE:
                collector.interrupt(round(before * 1000))
                due = min(due, _next(now, batch))
            if now >= due:
                collector.repeat(round((_next(now, batch) - batch) * 1000))
                due = _next(now, batch)
            elif len(collector.batch.times) < _MANY:
                continue
            if collector.batch.times or collector.batch.states or collector.has_states:
                await self._store.write(collector)


def _next(now: float, batch: float) -> float:
    """Return the time of the next batch: the times are the same each day, and each hour begins with one."""
    return (now // batch + 1) * batch
