"""Services for clients about the routines: those that run, and those that the owner keeps by a command."""

from collections.abc import Awaitable, Iterator, Sequence
from contextlib import ExitStack, suppress
from typing import Final, Protocol, final

from homebot.apps.grants import ACT
from homebot.clock import zone_name
from homebot.devices.app_messages import (
    ChangeRoutineRequest,
    ChangeRoutineResponse,
    ProposeRoutineRequest,
    RoutineInfo,
    RoutinesRequest,
    RoutinesResponse,
)
from homebot.devices.client_rights import HARMLESS, ORDINARY
from homebot.devices.device import KeyValue
from homebot.errors import ConfigError, HomebotError, UsageError
from homebot.routines.text import WrittenRoutine, acts_on, read_routines, with_act
from homebot.runtime.app_host import AppHost
from homebot.runtime.kept_routines import KeptRoutines
from homebot.support.folding import fold
from homebot.support.logger import get_logger
from homebot.support.similar import did_you_mean
from homebot.support.toml_text import toml_value

CHANGED: Final = "routine.changed"

_SOURCE: Final = "the text"
_log = get_logger(node="/homebot")


class _Apps(Protocol):
    """The starts and stops of apps."""

    async def load(self, *names: str) -> str:
        """Start apps, all or none."""

    async def unload(self, name: str) -> str:
        """Stop an app."""

    async def reload(self, name: str) -> str:
        """Restart an app with its current settings."""


@final
class RoutineServices:
    """Lists and changes the routines of *host*."""

    def __init__(self, host: AppHost, kept: KeptRoutines, apps: _Apps) -> None:
        self._host = host
        self._kept = kept
        self._apps = apps

    async def list(self, request: RoutinesRequest) -> RoutinesResponse:
        """Return all routines."""
        lacking: dict[str, list[str]] = {}
        hints = await self._host.routine_problems((), lacking) if request.check else {}
        infos = tuple(
            one.model_copy(
                update={"hints": tuple(hints.get(one.name, ())), "lacks": (*dict.fromkeys(lacking.get(one.name, ())),)}
            )
            for one in self._infos()
        )
        if request.device:
            meant = await self._host.routines_commanding(request.device) if infos else frozenset()
            infos = tuple(one for one in infos if one.name in meant)
        return RoutinesResponse(routines=infos, zone=zone_name(self._host.context.zone_name))

    async def change(self, request: ChangeRoutineRequest) -> ChangeRoutineResponse:
        """Start a routine, switch it on or off, or write it."""
        try:
            asks = await self._asks(request) if request.unless_asks else ()
        except HomebotError as exc:
            return _failure(exc)
        if asks:
            texts = ", ".join(f"{one.key} ({one.value})" if one.value else one.key for one in asks)
            return ChangeRoutineResponse(success=False, message=f"a person must agree: {texts}", asks=asks)
        return await self._answer(self._change(request), request.issuer)

    async def _asks(self, request: ChangeRoutineRequest) -> tuple[KeyValue, ...]:
        """Return the parts of a run that always ask, or the devices to which a text gives a right."""
        if request.change == "run":
            running = self._host.routines.get(self._named(request.name).app)
            reasons = {} if running is None else await self._host.why_asked(running)
            return tuple(KeyValue(key=name, value=reason) for name, reason in reasons.items())
        if request.change not in {"new", "edit"}:
            return ()
        known = {ORDINARY, HARMLESS}
        with suppress(ConfigError):  # a wrong text gave no right
            before = read_routines(self._named(request.name).text, _SOURCE) if request.change == "edit" else ()
            known |= {query for routine in before for query in acts_on(routine.table)}
        queries = [query for routine in self._read(request) for query in acts_on(routine.table) if query not in known]
        return tuple([KeyValue(key=await self._host.meant_by(query), value="") for query in dict.fromkeys(queries)])

    async def propose(self, request: ProposeRoutineRequest) -> ChangeRoutineResponse:
        """Keep a routine, which waits for the owner to enable it."""
        return await self._answer(self._propose(request), request.issuer)

    async def _answer(self, change: Awaitable[str], issuer: str) -> ChangeRoutineResponse:
        """Return the answer once the change is on the disk, so that a power cut does not undo it."""
        try:
            message = await change
        except HomebotError as exc:
            return _failure(exc)
        _log.info(CHANGED, message=f"{issuer or 'a program'} {message.splitlines()[0]}", client=issuer)
        if problem := await self._host.write_stores():
            message += f"\na restart would lose this, as it was not written: {problem}"
        return ChangeRoutineResponse(message=message)

    async def _propose(self, request: ProposeRoutineRequest) -> str:
        routines = read_routines(request.text, _SOURCE)
        if len(routines) != 1:
            raise UsageError(f"{_SOURCE} has {len(routines)} routines; propose one at a time")
        name = routines[0].name
        if ACT in routines[0].table:
            raise ConfigError(
                _SOURCE, f"routines.{routines[0].app}.{ACT}", "only the owner gives a right; leave it out"
            )
        await self._add(routines, request.issuer or "a program")
        text = f"proposed {name}; the owner enables it: homebot routine enable {name!r}"
        return await self._with_hints(text, *routines)

    async def _change(self, request: ChangeRoutineRequest) -> str:
        if request.change == "new":
            routines = self._read(request)
            await self._add(routines, of_habit=request.of_habit)
            return await self._with_hints(f"added {', '.join(one.name for one in routines)}", *routines)
        meant = self._named(request.name)
        match request.change:
            case "edit":
                return await self._edit(meant, self._read(request))
            case "remove":
                await self._remove(meant)
                return f"removed {meant.name}"
            case "enable":
                self._kept.approve(meant.app)
        running = self._host.routines.get(meant.app)
        if running is None:
            raise UsageError(f"{meant.name} does not run: {meant.problem or 'it was unloaded'}")
        return running.change(request.change)

    async def _add(self, routines: Sequence[WrittenRoutine], proposed_by: str = "", *, of_habit: bool = False) -> None:
        for one in routines:
            if one.app in self._host.running or one.app in self._kept:
                raise UsageError(f"a routine or app {one.app} is there already; choose another name, or edit that one")
        with ExitStack() as kept:
            for one in routines:
                kept.enter_context(self._kept.restored_on_error(one.app))
                self._kept.put(one, proposed_by, of_habit=of_habit)
            await self._apps.load(*[one.app for one in routines])

    async def _with_hints(self, text: str, *routines: WrittenRoutine) -> str:
        """Return *text* and the problems of *routines* in the house as it is now, each on its line."""
        hints = await self._host.routine_problems([one.name for one in routines])
        return "\n".join((text, *(f"{one.name}: {hint}" for one in routines for hint in hints.get(one.name, ()))))

    def _read(self, request: ChangeRoutineRequest) -> tuple[WrittenRoutine, ...]:
        """Return the routines that *request* writes, with the rights that it gives."""
        text = request.text
        if request.change == "edit":
            self._check_kept(meant := self._named(request.name))
            text = text or meant.text
        routines = read_routines(text, _SOURCE)
        if request.act:
            texts = [with_act(routine, request.act) for routine in routines]
            routines = read_routines("".join(texts), _SOURCE)
        return routines

    async def _edit(self, meant: RoutineInfo, routines: Sequence[WrittenRoutine]) -> str:
        if len(routines) != 1:
            raise UsageError(f"{_SOURCE} has {len(routines)} routines; {meant.name} is edited alone")
        if routines[0].app != meant.app:
            await self._add(routines, meant.proposed_by)
            await self._remove(meant)
            return f"renamed {meant.name} to {routines[0].name}"
        with self._kept.restored_on_error(meant.app):
            self._kept.put(routines[0], meant.proposed_by)
            await (self._apps.reload if meant.app in self._host.running else self._apps.load)(meant.app)
        return await self._with_hints(f"changed {routines[0].name}", *routines)

    async def _remove(self, meant: RoutineInfo) -> None:
        self._check_kept(meant)
        if meant.app in self._host.running:
            await self._apps.unload(meant.app)
        self._kept.remove(meant.app)
        self._host.context.store_of(meant.app).clear()

    def _check_kept(self, meant: RoutineInfo) -> None:
        if not meant.is_kept:
            raise UsageError(
                f"{meant.name} is in the configuration; change it there, and then: homebot app reload {meant.app}"
            )

    def _named(self, name: str) -> RoutineInfo:
        """Return the routine with the name, or the name of the app, *name*.

        Raises:
            UsageError: There is none.
        """
        known = {one.name: one for one in self._infos()}
        meant = [one for one in known.values() if fold(name) in {fold(one.name), fold(one.app)}]
        if not meant:
            hint = did_you_mean(name, known, f"routines are {', '.join(known) or 'none'}")
            raise UsageError(f"there is no routine {name!r}; {hint}")
        return meant[0]

    def _infos(self) -> Iterator[RoutineInfo]:
        running = self._host.routines
        for app, routine in running.items():
            more: dict[str, object] = {"proposed_by": self._kept.proposed_by(app)}
            info = routine.info()
            if (act := self._host.queries_granted(app)) is not None:
                more |= {"act": act, "text": f"{info.text}{ACT} = {toml_value(act)}\n"}
            if app in self._kept:
                more |= {"is_kept": True, "text": self._kept.text(app), "of_habit": self._kept.is_of_habit(app)}
            yield info.model_copy(update=more)
        for app, problem in self._host.wrong_routines.items():
            yield RoutineInfo(name=app, app=app, problem=problem)
        for app in self._kept:
            if app not in running:
                problem = self._kept.problems.get(app, "it does not run; `homebot app list` says why")
                yield RoutineInfo(name=app, app=app, is_kept=True, text=self._kept.text(app), problem=problem)


def _failure(error: HomebotError) -> ChangeRoutineResponse:
    others = error.others if isinstance(error, ConfigError) else ()
    return ChangeRoutineResponse(success=False, message="\n".join(map(str, (error, *others))))
