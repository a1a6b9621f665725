"""The history of devices, as applications read it."""

from __future__ import annotations

import homebot.devices.query
from homebot.devices.handles.handle import Handle
from homebot.devices.history_messages import (
    EnergyOfDay,
    HistorySeries,
    ReadEnergy,
    ReadEnergyRequest,
    ReadHistory,
    ReadHistoryRequest,
)
from homebot.devices.names import READ_ENERGY, READ_HISTORY
from homebot.devices.query import query_terms
from homebot.errors import ServiceUnavailableError, UsageError
from homebot.graph import Node
from homebot.messages import Time
from homebot.units import parse_duration

__all__ = ["read_energy", "read_history"]

_STARTS_WITHIN = 10.0
_NO_HISTORY = "no history is kept; `[history] enabled = true` in the configuration begins one"


async def read_history(
    node: Node, handle: Handle, capability: str, since: str | float, points: int = 0
) -> HistorySeries:
    """Return the past of *capability* of *handle*; without values where nothing is known.

    Raises:
        UsageError: No history is kept, or *since* is no length of time.
        ServiceError: No answer came.
    """
    device, part = handle.device, handle.part_id
    begin = Time.from_seconds(node.graph.clock.now() - parse_duration(since))
    request = ReadHistoryRequest(device=device.id, part=part, capability=capability, since=begin, points=points)
    client = node.create_client(ReadHistory, READ_HISTORY)
    try:
        await client.wait_for_service(_STARTS_WITHIN)
        answer = await client.call(request, timeout=30.0)
    except ServiceUnavailableError as exc:
        raise UsageError(_NO_HISTORY) from exc
    finally:
        client.close()
    if not answer.success:
        raise UsageError(answer.message)
    empty = HistorySeries(device=device.id, name=device.name, part=part, capability=capability)
    fitting = [one for one in answer.series if one.part == part]
    return fitting[0] if fitting else empty


async def read_energy(node: Node, query: str, since: str | float) -> tuple[EnergyOfDay, ...]:
    """Return the energy by day and device; errors as those of :func:`read_history`."""
    begin = Time.from_seconds(node.graph.clock.now() - parse_duration(since))
    terms = query_terms(homebot.devices.query.parse_query(query)) if query else ()
    client = node.create_client(ReadEnergy, READ_ENERGY)
    try:
        await client.wait_for_service(_STARTS_WITHIN)
        answer = await client.call(ReadEnergyRequest(query=terms, since=begin), timeout=30.0)
    except ServiceUnavailableError as exc:
        raise UsageError(_NO_HISTORY) from exc
    finally:
        client.close()
    if not answer.success:
        raise UsageError(answer.message)
    return answer.days
