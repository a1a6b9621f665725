"""Services for clients about the routines that run."""

from collections.abc import Iterator
from typing import final

from homebot.clock import zone_name
from homebot.devices.app_messages import (
    ChangeRoutineRequest,
    ChangeRoutineResponse,
    RoutinesRequest,
    RoutinesResponse,
)
from homebot.routines.routine import Routine
from homebot.runtime.app_host import AppHost
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

__all__ = ["RoutineServices"]


@final
class RoutineServices:
    """Lists and changes the routines of *host*."""

    def __init__(self, host: AppHost) -> None:
        self._host = host

    def list(self, _: RoutinesRequest) -> RoutinesResponse:
        """Return all routines."""
        infos = tuple(one.info() for one in self._routines())
        return RoutinesResponse(routines=infos, zone=zone_name(self._host.context.zone_name))

    def change(self, request: ChangeRoutineRequest) -> ChangeRoutineResponse:
        """Start a routine, or switch it on or off."""
        known = {one.settings.name: one for one in self._routines()}
        wanted = fold(request.name)
        meant = [one for name, one in known.items() if wanted in {fold(name), fold(one.node.name)}]
        if not meant:
            hint = did_you_mean(request.name, known, f"routines are {', '.join(known) or 'none'}")
            return ChangeRoutineResponse(success=False, message=f"there is no routine {request.name!r}; {hint}")
        return ChangeRoutineResponse(message=meant[0].change(request.change))

    def _routines(self) -> Iterator[Routine]:
        return (one for one in tuple(self._host.running.values()) if isinstance(one, Routine))
