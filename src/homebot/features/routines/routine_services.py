"""Services for clients about the routines: those that run, and those that the owner keeps by a command."""

from __future__ import annotations

from collections.abc import Awaitable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, suppress
from functools import cached_property, partial
from typing import TYPE_CHECKING, Final, final

from anyio import to_thread

from homebot.apps.grants import ACT, queries_of
from homebot.clock import zone_name
from homebot.config import Config
from homebot.control.policies.rights import APPROVAL, OF_RIGHTS
from homebot.devices.app_messages import (
    ChangeRoutine,
    ChangeRoutineRequest,
    ChangeRoutineResponse,
    ListRoutines,
    ProposeRoutine,
    ProposeRoutineRequest,
    RoutineInfo,
    RoutinesRequest,
    RoutinesResponse,
)
from homebot.devices.client_rights import EDIT_ROUTINE, HARMLESS, ORDINARY, NodeGrants
from homebot.devices.device import KeyValue
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.names import LIST_SCENES
from homebot.devices.scene_messages import ListScenes, ScenesRequest
from homebot.errors import ConfigError, HomebotError, ServiceError, UsageError
from homebot.features.routines import CHANGE_ROUTINE, KEPT_ROUTINES, LIST_ROUTINES, ROUTINE_GALLERY, ROUTINE_SENTENCES
from homebot.features.routines.kept_routines import KeptRoutines
from homebot.features.routines.messages import (
    ListRoutineSentences,
    ReadRoutineGallery,
    RoutineGalleryRequest,
    RoutineGalleryResponse,
    RoutineSentencesRequest,
    RoutineSentencesResponse,
)
from homebot.features.routines.program import Block, step_text
from homebot.features.routines.routine import Routine
from homebot.features.routines.text import WrittenRoutine, acts_on, read_routines, with_act
from homebot.graph import Node
from homebot.support.logger import get_logger
from homebot.support.names import resolve_name
from homebot.support.toml_text import toml_value
from homebot.words.mistakes import mistake_in
from homebot.words.own_language import in_language
from homebot.words.rights import read_scope
from homebot.words.suitable_parts import part_name

if TYPE_CHECKING:
    from homebot.feature_context import FeatureContext
    from homebot.features.routines.checks import HouseChecks
    from homebot.features.routines.effects import Effect

CHANGED: Final = "routine.changed"

_SOURCE: Final = "the text"
_log = get_logger(node="/routines")


@final
class RoutineServices:
    """Lists and changes the routines of *house*."""

    def __init__(self, node: Node, house: FeatureContext) -> None:
        self._node = node
        self._house = house
        self._apps = house.apps
        self.problems: dict[str, str] = {}

    def serve(self, name: str) -> None:
        """Create the service with this name."""
        if name == LIST_ROUTINES.name:
            self._node.create_service(ListRoutines, name, self.list)
        elif name == CHANGE_ROUTINE.name:
            self._node.create_service(ChangeRoutine, name, self.change)
        elif name == ROUTINE_GALLERY.name:
            self._node.create_service(ReadRoutineGallery, name, self.gallery)
        elif name == ROUTINE_SENTENCES.name:
            self._node.create_service(ListRoutineSentences, name, self.sentences)
        else:
            self._node.create_service(ProposeRoutine, name, self.propose)

    @cached_property
    def _kept(self) -> KeptRoutines:
        return KeptRoutines(self._house.store(KEPT_ROUTINES), self._grant, self.problems)

    @cached_property
    def _checks(self) -> HouseChecks:
        from homebot.features.routines.checks import HouseChecks  # noqa: PLC0415 - with the first question

        return HouseChecks(self._node, self._refusal, with_robots=not self._house.is_rehearsal)

    @cached_property
    def _lookup(self) -> DeviceLookup:
        return DeviceLookup(self._node)

    def kept_apps(self) -> Iterable[str]:
        """Return the names of the apps of the kept routines."""
        return self._kept

    def added_to(self, config: Config, app: str) -> Config:
        """Return *config* with the routine of *app*, if it is kept and right."""
        return self._kept.added_to(config, app)

    def grant_all(self) -> None:
        """Put the rights of the kept routines in force."""
        self._put_in_force(self.granted(self._apps.grants.now))

    def granted(self, grants: NodeGrants) -> NodeGrants:
        """Return *grants* with those of the kept routines."""
        for app in self._kept:
            grants = self._granted(app, grants)
        return grants

    async def hints(
        self, names: Collection[str] = (), lacking: dict[str, list[str]] | None = None
    ) -> Mapping[str, Sequence[str]]:
        """Return the faults of each routine, or those *names*, in the house as it is now, by its name.

        Args:
            lacking: Filled with the rights that each lacks, as queries.
        """
        routines = self._running
        if not routines:
            return {}
        settings = (one.settings.model_copy(update={"enabled": one.is_enabled}) for one in routines.values())
        problems = await self._checks.problems(settings, names, lacking)
        return {name: [self._said(problem) for problem in found] for name, found in problems.items()}

    async def gallery(self, request: RoutineGalleryRequest) -> RoutineGalleryResponse:
        """Return the ready-made routines, or the text of one."""
        from homebot.features.routines.gallery import gallery, listed, ready_made  # noqa: PLC0415 - reads its files

        await to_thread.run_sync(gallery)
        language = self._language(request)
        if not request.name:
            return RoutineGalleryResponse(success=True, routines=await to_thread.run_sync(listed, language))
        said = {one.key: one.value for one in request.inputs}
        try:
            text = await to_thread.run_sync(ready_made(request.name).filled, said, language)
        except UsageError as exc:
            return RoutineGalleryResponse(success=False, message=self._said(str(exc)))
        return RoutineGalleryResponse(success=True, text=text)

    def _language(self, request: RoutineGalleryRequest | RoutineSentencesRequest) -> str:
        return request.language or self._house.home.language

    def _said(self, message: str) -> str:
        """Return *message* as the house, or the text that it is about, says it."""
        return mistake_in(self._house.home.language, message)

    @property
    def _running(self) -> dict[str, Routine]:
        """The running routines, by the name of the app."""
        return {name: one for name, one in tuple(self._apps.running_apps.items()) if isinstance(one, Routine)}

    def _grant(self, app: str) -> None:
        """Bring the rights of a kept routine in line with its text."""
        self._put_in_force(self._granted(app, self._apps.grants.now))

    def _put_in_force(self, grants: NodeGrants) -> None:
        self._apps.grants.now = grants
        if (control := self._house.control()) is not None:
            control.forget_rights()

    def _granted(self, app: str, grants: NodeGrants) -> NodeGrants:
        """Return *grants* with those of a kept routine; an app of the configuration keeps its own."""
        node = f"/{app}"
        if not grants.tables.get(node, EDIT_ROUTINE).startswith(EDIT_ROUTINE):
            return grants
        with suppress(ConfigError):  # a routine with a mistake does not run
            if app in self._kept:
                return grants.having(node, *self._kept.grants(app))
        return grants.without(node)

    def _queries_granted(self, app: str) -> tuple[str, ...] | None:
        """Return the queries of the key ``act`` of a routine; None if it has none."""
        scope = self._apps.grants.now.scopes.get(f"/{app}")
        return None if scope is None else queries_of(scope)

    def _refusal(self, app: str, effect: Effect) -> tuple[str, str]:
        """Return why *effect* of *app* is refused for lack of a right or an approval, and that right, as a query."""
        control, part = self._house.control(), effect.device.part(effect.part)
        if control is None or part is None or effect.may_be:
            return "", ""
        refused = control.preview(effect.request(app), effect.device, part)
        if refused is None or refused.policy not in OF_RIGHTS | {APPROVAL}:
            return "", ""
        return refused.reason, f'id="{effect.device.id}"' if refused.policy in OF_RIGHTS else ""

    async def _why_asked(self, routine: Routine) -> Mapping[str, str]:
        """Return why a person must agree to the steps of *routine*, by the names of the parts."""
        control, reasons = self._house.control(), dict[str, str]()
        for effect in await self._checks.effects(routine.settings):
            if control is not None and (part := effect.device.part(effect.part)) is not None:
                reason = await control.why_asked(effect.request(routine.node.name), effect.device, part)
                reasons |= {part_name(effect.device, part): reason} if reason else {}
        return reasons

    async def list(self, request: RoutinesRequest) -> RoutinesResponse:
        """Return all routines."""
        lacking: dict[str, list[str]] = {}
        hints = await self.hints((), lacking) if request.check else {}
        infos = tuple(
            one.model_copy(
                update={"hints": tuple(hints.get(one.name, ())), "lacks": (*dict.fromkeys(lacking.get(one.name, ())),)}
            )
            for one in self._infos()
        )
        if request.device:
            meant = (
                await self._checks.commanding((one.settings for one in self._running.values()), request.device)
                if infos
                else frozenset()
            )
            infos = tuple(one for one in infos if one.name in meant)
        if (language := self._house.home.language) != "en":
            steps = {app: one.settings.do for app, one in self._running.items()}
            infos = tuple(_shown(one, steps.get(one.app, ()), language) for one in infos)
        return RoutinesResponse(routines=infos, zone=zone_name(self._house.home.zone))

    async def sentences(self, request: RoutineSentencesRequest) -> RoutineSentencesResponse:
        """Return the sentences that a routine may have about a device, or about none."""
        from homebot.features.routines import sentences  # noqa: PLC0415 - for the form of the page
        from homebot.words.device_words import DeviceWords  # noqa: PLC0415 - likewise

        devices = await self._lookup.all_known()
        language = self._language(request)
        words = await to_thread.run_sync(DeviceWords, devices)
        device = next((one for one in devices if one.id == request.device), None)
        if device is not None:
            return await to_thread.run_sync(sentences.of_device, words, device, language)
        if not request.device:
            scenes: tuple[str, ...] = ()
            with closing(self._node.create_client(ListScenes, LIST_SCENES)) as client, suppress(ServiceError):
                scenes = tuple([one.name for one in (await client.call(ScenesRequest())).scenes])
            names = [info.name for info in self._infos()]
            has_place = self._house.home.latitude is not None
            of_house = partial(sentences.of_house, has_place=has_place)
            return await to_thread.run_sync(of_house, words, language, scenes, names)
        raise UsageError(f"device: there is no device {request.device!r}; `homebot devices` lists those that there are")

    async def change(self, request: ChangeRoutineRequest) -> ChangeRoutineResponse:
        """Start a routine, switch it on or off, or write it."""
        try:
            asks = await self._asks(request) if request.unless_asks else ()
        except HomebotError as exc:
            return self._failure(exc)
        if asks:
            texts = ", ".join(f"{one.key} ({one.value})" if one.value else one.key for one in asks)
            return ChangeRoutineResponse(success=False, message=f"a person must agree: {texts}", asks=asks)
        return await self._answer(self._change(request), request.issuer)

    async def _asks(self, request: ChangeRoutineRequest) -> tuple[KeyValue, ...]:
        """Return the parts of a run that always ask, or the devices to which a text gives a right."""
        if request.change == "run":
            running = self._running.get(self._named(request.name).app)
            reasons = {} if running is None else await self._why_asked(running)
            return tuple(KeyValue(key=name, value=reason) for name, reason in reasons.items())
        if request.change not in {"new", "edit"}:
            return ()
        known = {ORDINARY, HARMLESS}
        with suppress(ConfigError):  # a wrong text gave no right
            before = read_routines(self._named(request.name).text, _SOURCE) if request.change == "edit" else ()
            known |= {query for routine in before for query in acts_on(routine.table)}
        queries = [query for routine in self._read(request) for query in acts_on(routine.table) if query not in known]
        return tuple([KeyValue(key=await self._checks.named(query), value="") for query in dict.fromkeys(queries)])

    async def propose(self, request: ProposeRoutineRequest) -> ChangeRoutineResponse:
        """Keep a routine, which waits for the owner to enable it."""
        return await self._answer(self._propose(request), request.issuer)

    async def _answer(self, change: Awaitable[str], issuer: str) -> ChangeRoutineResponse:
        """Return the answer once the change is on the disk, so that a power cut does not undo it."""
        try:
            message = await change
        except HomebotError as exc:
            return self._failure(exc)
        _log.info(CHANGED, message=f"{issuer or 'a program'} {message.splitlines()[0]}", client=issuer)
        if problem := await self._house.write_stores():
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
        running = self._running.get(meant.app)
        if running is None:
            raise UsageError(f"{meant.name} does not run: {meant.problem or 'it was unloaded'}")
        return running.change(request.change)

    async def _add(self, routines: Sequence[WrittenRoutine], proposed_by: str = "", *, of_habit: bool = False) -> None:
        for one in routines:
            if one.app in self._apps.running_apps or one.app in self._kept:
                raise UsageError(f"a routine or app {one.app} is there already; choose another name, or edit that one")
        with ExitStack() as kept:
            for one in routines:
                kept.enter_context(self._kept.restored_on_error(one.app))
                self._kept.put(one, proposed_by, of_habit=of_habit)
            await self._apps.load(*[one.app for one in routines])

    async def _with_hints(self, text: str, *routines: WrittenRoutine) -> str:
        """Return *text* and the problems of *routines* in the house as it is now, each on its line."""
        hints = await self.hints([one.name for one in routines])
        return "\n".join((text, *(f"{one.name}: {hint}" for one in routines for hint in hints.get(one.name, ()))))

    def _read(self, request: ChangeRoutineRequest) -> tuple[WrittenRoutine, ...]:
        """Return the routines that *request* writes, with the rights that it gives."""
        text = request.text
        if request.change == "edit":
            self._check_kept(meant := self._named(request.name))
            text = text or meant.text
        routines = read_routines(text, _SOURCE)
        if request.act:
            read_scope([f"{ACT}: {query}" for query in request.act])
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
            await (self._apps.reload if meant.app in self._apps.running_apps else self._apps.load)(meant.app)
        return await self._with_hints(f"changed {routines[0].name}", *routines)

    async def _remove(self, meant: RoutineInfo) -> None:
        self._check_kept(meant)
        if meant.app in self._apps.running_apps:
            await self._apps.unload(meant.app)
        self._kept.remove(meant.app)
        self._house.store(meant.app).clear()

    def _check_kept(self, meant: RoutineInfo) -> None:
        if not meant.is_kept:
            raise UsageError(
                f"{meant.name} is in the configuration; change it there, and then: homebot app reload {meant.app}"
            )

    def _failure(self, error: HomebotError) -> ChangeRoutineResponse:
        others = error.others if isinstance(error, ConfigError) else ()
        return ChangeRoutineResponse(success=False, message=self._said("\n".join(map(str, (error, *others)))))

    def _named(self, name: str) -> RoutineInfo:
        """Return the routine with the name, or the name of the app, *name*.

        Raises:
            UsageError: There is none.
        """
        infos = [*self._infos()]
        named = {spelled: info for info in infos for spelled in (info.app, info.name)}
        known = ", ".join(info.name for info in infos) or "none"
        return named[resolve_name("routine", name, named, f"routines are {known}")]

    def _infos(self) -> Iterator[RoutineInfo]:
        running = self._running
        for app, routine in running.items():
            more: dict[str, object] = {"proposed_by": self._kept.proposed_by(app)}
            info = routine.info()
            if (act := self._queries_granted(app)) is not None:
                more |= {"act": act, "text": f"{info.text}{ACT} = {toml_value(act)}\n"}
            if app in self._kept:
                more |= {"is_kept": True, "text": self._kept.text(app), "of_habit": self._kept.is_of_habit(app)}
            yield info.model_copy(update=more)
        for app, problem in self._apps.wrong_apps("routines").items():
            yield RoutineInfo(name=app, app=app, problem=self._said(problem))
        for app in self._kept:
            if app not in running:
                problem = self._said(self.problems.get(app, "it does not run; `homebot app list` says why"))
                yield RoutineInfo(name=app, app=app, is_kept=True, text=self._kept.text(app), problem=problem)


def _shown(info: RoutineInfo, steps: Sequence[str | Block], language: str) -> RoutineInfo:
    """Return *info* with its lines as *language* says them; ``text`` stays as it was written."""
    return info.model_copy(
        update={
            "when": tuple(in_language(text, "trigger", language) for text in info.when),
            "conditions": tuple(in_language(text, "condition", language) for text in info.conditions),
            "steps": tuple(step_text(step, language) for step in steps),
        }
    )


def start(node: Node, house: FeatureContext) -> RoutineServices:
    """Return the server, with the rights of the kept routines in force."""
    services = RoutineServices(node, house)
    services.grant_all()
    return services
