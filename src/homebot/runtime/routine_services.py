"""Services for clients about the routines that run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, final

from homebot.clock import zone_name
from homebot.devices.names import CHANGE_ROUTINE, LIST_ROUTINES
from homebot.devices.routine_messages import (
    ChangeRoutine,
    ChangeRoutineRequest,
    ChangeRoutineResponse,
    ListRoutines,
    RoutinesRequest,
    RoutinesResponse,
)
from homebot.graph import Node
from homebot.runtime.app_host import AppHost
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

if TYPE_CHECKING:
    from homebot.routines.routine import Routine

__all__ = ["RoutineServices"]


@final
class RoutineServices:
    """Lists and changes routines."""

    def __init__(self, node: Node, host: AppHost) -> None:
        self._host = host
        node.create_service(ListRoutines, LIST_ROUTINES, self._list)
        node.create_service(ChangeRoutine, CHANGE_ROUTINE, self._change)

    def _routines(self) -> Iterator[Routine]:
        from homebot.routines.routine import Routine  # noqa: PLC0415 - many homes have none

        return (one for one in tuple(self._host.running.values()) if isinstance(one, Routine))

    def _list(self, _: RoutinesRequest) -> RoutinesResponse:
        infos = tuple(one.info() for one in self._routines())
        return RoutinesResponse(routines=infos, zone=zone_name(self._host.context.zone_name))

    def _change(self, request: ChangeRoutineRequest) -> ChangeRoutineResponse:
        known = {one.settings.name: one for one in self._routines()}
        wanted = fold(request.name)
        meant = [one for name, one in known.items() if wanted in {fold(name), fold(one.node.name)}]
        if not meant:
            hint = did_you_mean(request.name, known, f"routines are {', '.join(known) or 'none'}")
            return ChangeRoutineResponse(success=False, message=f"there is no routine {request.name!r}; {hint}")
        return ChangeRoutineResponse(message=meant[0].change(request.change))
