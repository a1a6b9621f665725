"""Client of the history of devices for applications."""

from typing import TypeVar, final

from homebot.devices.handles.handle import Handle
from homebot.devices.history_messages import (
    MAX_POINTS,
    EnergyOfDay,
    HistorySeries,
    ReadEnergy,
    ReadEnergyRequest,
    ReadHistory,
    ReadHistoryRequest,
)
from homebot.devices.names import READ_ENERGY, READ_HISTORY
from homebot.devices.query.term_messages import query_words
from homebot.errors import ServiceUnavailableError, UsageError
from homebot.graph import Node
from homebot.messages import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType
from homebot.units import parse_duration

RequestT = TypeVar("RequestT", bound=Message)
AnswerT = TypeVar("AnswerT", bound=ServiceAnswer)

_STARTS_WITHIN = 10.0
_NO_HISTORY = "no history is kept; set `[history] enabled = true` in the configuration to start one"


@final
class HistoryClient:
    """Reads the history for the app of a node; see :meth:`homebot.apps.App.history`."""

    def __init__(self, node: Node) -> None:
        self._node = node

    async def read(self, handle: Handle, capability: str, since: str | float, points: int) -> HistorySeries:
        """Return the history of *capability* of *handle*; without values if nothing is known."""
        if not isinstance(handle, Handle):
            raise UsageError(f"history() takes a handle, as find() returns it, not {handle!r:.60}")
        if type(points) is not int or not 0 <= points <= MAX_POINTS:
            raise UsageError(f"points: {points!r} is not a whole number from 0 to {MAX_POINTS:,}")
        device, part = handle.device.id, handle.part_id
        request = ReadHistoryRequest(
            device=device, part=part, capability=capability, since=self._begin(since), points=points
        )
        answer = await self._call(ReadHistory, READ_HISTORY, request)
        empty = HistorySeries(device=device, name=handle.device.name, part=part, capability=capability)
        return next((series for series in answer.series if series.part == part), empty)

    async def read_energy(self, query: str, since: str | float) -> tuple[EnergyOfDay, ...]:
        """Return the energy by day and device."""
        request = ReadEnergyRequest(query=query_words(str(query)), since=self._begin(since))
        return (await self._call(ReadEnergy, READ_ENERGY, request)).days

    def _begin(self, since: str | float) -> Time:
        return Time.from_seconds(max(0.0, self._node.graph.clock.now() - parse_duration(since, "since")))

    async def _call(self, service: ServiceType[RequestT, AnswerT], name: str, request: RequestT) -> AnswerT:
        """Return the answer to *request*; raise `UsageError` if it is wrong, or there is no history."""
        client = self._node.create_client(service, name)
        try:
            await client.wait_for_service(_STARTS_WITHIN)
            answer = await client.call(request, timeout=30.0)
        except ServiceUnavailableError as exc:
            raise UsageError(_NO_HISTORY) from exc
        finally:
            client.close()
        if not answer.success:
            raise UsageError(answer.message)
        return answer
