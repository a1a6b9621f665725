"""The runtime: builds the graph from a configuration, starts all components in order, stops them in reverse.

The order is: embedded broker, link to other machines, gateways, directory, apps, robots, door, simulated house.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import KW_ONLY, dataclass, field, replace
from datetime import datetime
from functools import cache, cached_property, partial
from http import HTTPStatus
from importlib import import_module
from pathlib import Path
from random import Random
from types import TracebackType
from typing import TYPE_CHECKING, Self, TypeVar, cast

import anyio
from anyio import to_thread
from anyio.abc import TaskStatus

from homebot.apps import App
from homebot.bridges.rosbridge import RosbridgeServer
from homebot.clock import Clock, LoopClock, home_time, read_zone
from homebot.config import Config
from homebot.control import Control
from homebot.devices.access_messages import ListTokens
from homebot.devices.app_messages import ChangeAppResponse, Reload
from homebot.devices.client_rights import LOCAL_RIGHTS, SIMULATED_HOUSE_RIGHTS, NodeGrants
from homebot.devices.exposure import NETWORK_SERVICES, NETWORK_SERVICES_QOS, NetworkService
from homebot.devices.gateway_messages import (
    GatewayState,
    RestartGateway,
    RestartGatewayRequest,
    RestartGatewayResponse,
)
from homebot.devices.health import GetHealth
from homebot.devices.names import COPY_FILES, LIST_TOKENS, POSE_TOPICS, RELOAD, RESTART_GATEWAY, GatewayNames
from homebot.devices.own_services import is_own, row_of_service
from homebot.discovery import Directory, OwnerFacts
from homebot.errors import UsageError
from homebot.feature import Feature, all_features, load
from homebot.gateways import Gateway, GatewayContext
from homebot.graph import EntityKind, Graph, Node, RosoutFeed, qos_profile_latched
from homebot.places import HousePlan
from homebot.runtime.app_host import STORE_FILE, AppHost, table_of
from homebot.runtime.app_loading import AppPlanner
from homebot.runtime.app_manager import AppManager
from homebot.runtime.health import RuntimeHealth
from homebot.runtime.plan import JOURNAL_FILE, OWN_NODES, Plan, PlannedComponent, make_plan
from homebot.runtime.supervisor import Supervisor
from homebot.support.installation import INSTALLATION_FILE, Installation
from homebot.support.isolation import run_as
from homebot.support.logger import get_logger, observed_lines
from homebot.support.names import did_you_mean
from homebot.support.owner_token import OwnerToken, make_owner_token
from homebot.support.production_loop import LoopWatch, load_beside_loop

if TYPE_CHECKING:
    from pydantic import BaseModel

    from homebot.bridges.rosbridge.first_code import FirstCode
    from homebot.control.open_command import SimulatedExecution
    from homebot.devices.services import IndexRow
    from homebot.feature_context import AppKeeper, FeatureContext, FeatureServer, RunObserver
    from homebot.graph.endpoint import EndpointInfo
    from homebot.house import World
    from homebot.recording.lines import RecordingHeader
    from homebot.runtime.session_keeper import SessionKeeper
    from homebot.runtime.simulated_house import HouseOfRun

RUNNING = "runtime.running"
APPS = "runtime.apps"
NO_OWNER = "runtime.no_owner_token"
STOPPING = "runtime.stopping"

_LATER = 2.0
"""Seconds after which features begin to run, so that they do not delay the start, and devices are known."""

ServiceT = TypeVar("ServiceT")

_log = get_logger(node="/homebot")


async def _track_robots(
    graph: Graph, plan: Plan, rooms: Callable[[], HousePlan], *, task_status: TaskStatus[None]
) -> None:
    """Track robots until cancelled; if none is configured, start when the first one publishes its pose."""
    if not plan.names_robots:
        task_status.started()
        await _first_pose_topic(graph, plan)
    from homebot.robots.tracker import RobotTracker  # noqa: PLC0415 - few houses have a robot

    async with Node(graph, "robots") as node:
        tracker = RobotTracker(node, plan.robot_owners(), rooms, plan.robots)
        await run_as(node.full_name, partial(tracker.serve, task_status=task_status))


async def _first_pose_topic(graph: Graph, plan: Plan) -> None:
    def has_pose(entity: EndpointInfo) -> bool:
        if entity.kind is not EntityKind.PUBLISHER or entity.name.rpartition("/")[2] not in POSE_TOPICS:
            return False
        return plan.robot_owners().of_topic(entity.name) is not None

    with graph.watch() as changes:
        if any(map(has_pose, graph.get_endpoints(kind=EntityKind.PUBLISHER))):
            return
        async for change in changes:
            if has_pose(change.entity):
                return


@dataclass(eq=False, repr=False)
class Runtime:
    """A running homebot, used as ``async with Runtime(config) as runtime``.

    Entering starts everything and returns when it is ready; leaving stops everything in reverse order.

    Args:
        apps: Classes of apps by name, beside those that *config* names; ``[apps.NAME]`` has the settings of each.
        house: A simulated house whose devices connect to the embedded broker, or are found by gateways that are added
            if the configuration has none of that name; its state is that of last midnight, UTC.
        robot: The name of the ROS robot in a *house* with a floor plan; empty for none.
        house_broker: The address of another broker for the devices of the *house*, as in a gateway's table; real
            devices may be there too. Empty for the embedded broker.
        with_door: Whether to listen for rosbridge clients, such as the command line.
        clock: The clock; by default that of the running loop.
        services: Running services for gateways, such as an in-memory broker, which are not started then.
        random: The source of random numbers; a seeded one makes runs reproducible.
        loop_watch: Detects code that blocks the event loop, for health reports.
        lost_lines: Returns the number of log lines lost so far.
        trusts_apps: Whether apps may command always-ask devices without a grant, because no device is real; always so
            with a *house*. Then no device needs an approval either, unless the *house* has gateways that may find real
            ones.
        index_file: The file in which the directory keeps devices across restarts; None for none.
        owner_file: The file with the owner's token, which is made if there is none; None for none. The rosbridge server
            of a simulated house needs none.
        observers: Functions that observe the run from before its apps until after them, by name.
        is_dry_run: Whether nothing is sent to any device: gateways only observe, and commands are recorded instead of
            sent.
        rehearsal: Answers commands in place of the devices, as in a replay; by default that of a dry run, if it is one.
        known: Initial content of the directory without an *index_file*, as in a replay.
        detected: Motion sensors that have detected motion before, in a replay.
        read_config: Reads the configuration again, for apps that are loaded later; by default *config* is used.
        watches_apps: Whether an app is reloaded when its file changes.
        show_code: Shows a new owner the address of the page, and the code by which it logs in once; called if the
            rosbridge server has no token but the owner's. None for no code.
        restart: Ends the run, and begins another; None where only a person can.

    Attributes:
        rosbridge: The server for rosbridge clients; None before it listens.

    Raises:
        ConfigError: A class cannot be found, a table is wrong, or there is no gateway for the devices of *house*.
    """

    config: Config
    _: KW_ONLY
    apps: Mapping[str, type[App]] = field(default_factory=dict)
    house: World | None = None
    robot: str = ""
    house_broker: str = ""
    with_door: bool = True
    clock: Clock | None = None
    services: Iterable[object] = ()
    random: Random | None = None
    trusts_apps: bool = False
    index_file: Path | None = None
    owner_file: Path | None = None
    loop_watch: LoopWatch | None = None
    lost_lines: Callable[[], int] = lambda: 0
    observers: Mapping[str, RunObserver] = field(default_factory=dict)
    is_dry_run: bool = False
    rehearsal: SimulatedExecution | None = None
    known: Sequence[IndexRow] = ()
    detected: Sequence[str] = ()
    read_config: Callable[[], Config] | None = None
    watches_apps: bool = False
    show_code: Callable[[str, str], None] | None = None
    restart: Callable[[], None] | None = None

    def __post_init__(self) -> None:
        self._house = None if self.house is None else self._house_of_run(self.house)
        self._gateway_node: Callable[[Graph, str], Node] = partial(Node, namespace="/gateway")
        self._plan = self._make_plan(self.config)
        self._needed = tuple(
            service for gateway in self._plan.gateways for service in gateway.kind.host_services(gateway.settings)
        )
        is_all_simulated = self._house is not None and not self._house.may_meet_real_devices(self._plan)
        self._local_rights = SIMULATED_HOUSE_RIGHTS if is_all_simulated else LOCAL_RIGHTS
        self._approves_all = self.trusts_apps or is_all_simulated
        self.trusts_apps = self.trusts_apps or self.house is not None
        self._session: CurrentSession | None = None
        if self._plan.link is not None:
            from homebot.bridges.zenoh.current_session import CurrentSession  # noqa: PLC0415 - few houses have a link

            self._session = CurrentSession()
        self._session_keeper: SessionKeeper | None = None
        self._installation = Installation(self._beside_index(INSTALLATION_FILE), self.random)
        self._context = self._gateway_context()
        self._owner: OwnerFacts
        self._servers: dict[str, Callable[[], FeatureServer]] = {}
        self._controller: Control | None = None
        self._index: Directory | None = None
        self._stack = AsyncExitStack()
        self._clock = self.clock or LoopClock()
        self.graph = Graph(self._clock)
        self.app_host = AppHost(
            self.graph,
            self._plan,
            self._beside_index(STORE_FILE),
            self._clock,
            self._keepers,
            rehearses=self.rehearsal is not None,
        )
        if self._plan.interfaces is not None:
            self.graph.interfaces = self._plan.interfaces
        if self._session is not None:
            from homebot.runtime.session_keeper import SessionKeeper  # noqa: PLC0415 - few houses have a link

            self._session_keeper = SessionKeeper(self.graph, self._session, lambda: self._plan, self._owner_token)
        self.supervisor = Supervisor(self._clock)
        self._read = self.read_config or (lambda: self.config)
        planner = AppPlanner(self._read, self._add_kept, self._plan.grants, self.apps)
        self.app_manager = AppManager(self.supervisor, self.app_host, planner)
        self.rosbridge: RosbridgeServer | None = None
        self._first_code: FirstCode | None = None
        self._start_is_cut = False
        self._reloading = anyio.Lock()
        self._reloaded = ChangeAppResponse()

    def _gateway_context(self) -> GatewayContext:
        return GatewayContext.of(
            self._installation,
            *self.services,
            *filter(None, (self._session,)),
            random=self.random,
            is_dry_run=self.is_dry_run,
            home=self._house.home if self._house is not None else self._plan.home,
        )

    def _house_of_run(self, world: World) -> HouseOfRun:
        from homebot.runtime.simulated_house import HouseOfRun  # noqa: PLC0415 - a real house needs no simulated one

        return HouseOfRun(world, self.config.gateways, self.robot, self.house_broker)

    def _add_kept(self, config: Config, app: str) -> Config:
        for _, keeper in self._keepers():
            config = keeper.added_to(config, app)
        return config

    def _keepers(self) -> Iterator[tuple[str, AppKeeper]]:
        """Yield the features that keep apps and have any, each with the word for these."""
        for feature in all_features():
            if feature.keeps_apps and feature.name in self._servers:
                apps = self.app_host.running.values()
                if any(map(self.app_host.has_kept, feature.stores)) or any(
                    table_of(type(app)) in feature.tables for app in apps
                ):
                    yield feature.keeps_apps, cast("AppKeeper", self._servers[feature.name]())

    def _make_plan(self, config: Config) -> Plan:
        if self._house is not None:
            config = config.model_copy(update={"gateways": {**self._house.network.gateways(), **config.gateways}})
        if self.is_dry_run:
            from homebot.runtime.dry_run import DryRun, MutedNode, observing  # noqa: PLC0415 - few runs are one

            config = observing(config)
            self._gateway_node = MutedNode
            self.rehearsal = self.rehearsal or DryRun()
        plan = make_plan(config, self.apps)
        return plan if self._house is None else self._house.complete(plan, config.source)

    async def __aenter__(self) -> Self:
        """Start everything.

        Raises:
            UsageError: A component cannot be started as configured; the started ones are stopped again.
        """
        try:
            await self._start(self._stack)
        except BaseException as exc:
            await self._stop(exc)
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        _log.info(STOPPING, message="stopping")
        await self._stop(error)

    def service(self, kind: type[ServiceT]) -> ServiceT | None:
        """Return the service of the class *kind* that runs for the gateways; None if there is none."""
        return self._context.service(kind)

    async def reload(self, read: Callable[[], Config], *, may_lose: bool = False) -> ChangeAppResponse:
        """Apply the configuration that *read* returns, called in a thread, unless it has a mistake or lacks limits."""
        from homebot.runtime.reload import RunningParts, reload_configuration  # noqa: PLC0415 - few runs are reloaded

        parts = RunningParts(lambda: self.rosbridge, self._controller, self._index, self._granted)
        async with self._reloading:
            self._plan, self._reloaded = await reload_configuration(
                self.config, self._plan, parts, read, self._make_plan, may_lose=may_lose
            )
            self.app_host.left_out = self._plan.left_out
            self.app_host.send_by(self._plan.notify)
            if self._session_keeper is not None:
                self._session_keeper.reload()
            return self._reloaded

    def _granted(self, grants: NodeGrants) -> NodeGrants:
        for _, keeper in self._keepers():
            grants = keeper.granted(grants)
        return grants

    def cut_start_short(self) -> None:
        """Abort the start: entering returns at once, and nothing more is started."""
        self._start_is_cut = True
        self.supervisor.hurry()

    async def _stop(self, error: BaseException | None) -> None:
        """Stop all started components. An error is raised without exception groups.

        A cancellation is passed to the task groups, which know whether it is their own: otherwise it is raised again in
        each, and if two are each other's cause, anyio 4.16 searches for the first one forever.
        """
        if isinstance(error, anyio.get_cancelled_exc_class()):
            await self._stack.__aexit__(type(error), error, error.__traceback__)
        else:
            await self._stack.aclose()

    async def _start(self, stack: AsyncExitStack) -> None:
        stack.callback(self._installation.close)
        if self.with_door:  # checked first: components before the rosbridge server may wait for another homebot's files
            await to_thread.run_sync(self._plan.door.check_port)
        main = await stack.enter_async_context(Node(self.graph, "homebot"))
        stack.enter_context(observed_lines(RosoutFeed(main)))
        self.app_manager.offer_services(main)
        home, reloaded, folder = self._plan.home, lambda: self._reloaded, self._installation.folder
        RuntimeHealth(main, home, self.supervisor, self.loop_watch, self.lost_lines, self.app_host, reloaded, folder)
        load_copies = partial(import_module, "homebot.runtime.saved_files")
        main.offer_service("std_srvs/srv/Trigger", COPY_FILES, partial(self._serve_copies, main), load_copies)
        main.create_service(Reload, RELOAD, lambda asked: self.reload(self._read, may_lose=asked.allow_removal))
        main.create_service(RestartGateway, RESTART_GATEWAY, self._restart_gateway)
        self._network_services = main.create_publisher(NetworkService, NETWORK_SERVICES, NETWORK_SERVICES_QOS)
        # Each in-process peer that gateways need is started once, unless it was passed in.
        running = dict(self._context.services)
        if self._house is not None:
            for given in await stack.enter_async_context(self._house.network.running(self._context.random)):
                running[type(given)] = given
        for service in self._needed:
            if service.kind not in running:
                running[service.kind] = await stack.enter_async_context(service.start(self.graph, self._clock))
        plugins = frozenset(str(table.get("class", name)) for name, table in self.config.gateways.items())
        self._context = replace(self._context, services=running, gateways=plugins)
        gateways = tuple(
            replace(gateway, settings=gateway.kind.resolve(gateway.settings, self._context))
            for gateway in self._plan.gateways
        )
        zone = await to_thread.run_sync(read_zone, self._plan.home_settings.zone)
        home_time.set(lambda: datetime.fromtimestamp(self._clock.now(), zone))
        await self.app_host.read_stores(main)
        stack.push_async_callback(self.app_host.close_stores)
        for component in self._components(gateways):
            if self._start_is_cut:
                return
            await stack.enter_async_context(component)
        if not self._start_is_cut:
            self._greet()
            # Loaded last: it takes longer than other parts of the start, and clients need a handshake first.
            await stack.enter_async_context(self.supervisor.running("rosapi", self._rosapi))
            self._check_rights()

    def _components(
        self, gateways: tuple[PlannedComponent[Gateway], ...]
    ) -> Iterator[AbstractAsyncContextManager[None]]:
        """Yield components in the order of their start; each is created when the previous ones are ready."""
        running = self.supervisor.running
        if self._session_keeper is not None and not self.is_dry_run:
            yield running("ros2", self._session_keeper.serve)
        for gateway in gateways:
            name = gateway.name
            work, down = partial(self._gateway, gateway), partial(self._gateway_down, name)
            yield running(f"gateway/{name}", work, f"gateway {name}", down=down)
        if not self._plan.as_other_machine:
            yield from self._house_components()
        if self.with_door:
            yield running("rosbridge_websocket", self._serve_rosbridge, "door")
        if self._house is not None:
            yield running("homebot/house", partial(self._house.serve, self._context, self.graph), "house")

    def _house_components(self) -> Iterator[AbstractAsyncContextManager[None]]:
        """Yield what a house has once: its index, control, apps and histories, and where its robots are."""
        running = self.supervisor.running
        yield running("discovery", self._directory)
        yield running("control", self._control)
        # Stopped before control, so that what they hold can be put back.
        yield from (
            running(feature.name, partial(self._feature, feature)) for feature in all_features() if feature.server
        )
        for name, observe in self.observers.items():
            yield running(f"homebot/{name}", partial(observe, self._feature_context), name)
        yield self.app_manager.running(self._plan.apps, lambda: self._start_is_cut)
        if self.watches_apps:
            yield running("homebot/app_watch", self.app_manager.reload_changed, "app_watch")
        for feature in all_features():
            if feature.runs and feature.is_wanted(self._feature_context):
                yield running(feature.name, partial(self._run_feature, feature))
        yield running("robots", partial(_track_robots, self.graph, self._plan, lambda: self._owner.plan))

    def _check_rights(self) -> None:
        """Check that each service of a node of homebot itself has a row with the right that a client needs.

        Raises:
            UsageError: One has none.
        """
        own = {f"/{name}" for name in OWN_NODES}
        services = self.graph.get_endpoints(kind=EntityKind.SERVICE)
        lacking = [
            service.name
            for service in services
            if service.node in own and is_own(service.name) and row_of_service(service.name) is None
        ]
        if lacking:
            raise UsageError(f"services without a right: {', '.join(lacking)}; add them to CORE_SERVICES")

    async def _gateway(self, component: PlannedComponent[Gateway], *, task_status: TaskStatus[None]) -> None:
        async with self._gateway_node(self.graph, component.name) as node:
            component.offer_settings(node)
            gateway = component.kind(node, component.settings, self._context)
            await run_as(node.full_name, partial(gateway.serve, task_status=task_status))

    @asynccontextmanager
    async def _gateway_down(self, name: str, why: str) -> AsyncIterator[None]:
        """Tell in place of a gateway that waits for its restart that it is away."""
        async with self._gateway_node(self.graph, name) as node:
            states = node.create_publisher(GatewayState, GatewayNames(name).state, qos_profile_latched)
            reason = f"{why}; at once: homebot gateway restart {name}"
            states.publish(GatewayState(state="unavailable", reason=reason, acts=True))
            yield

    async def _restart_gateway(self, request: RestartGatewayRequest) -> RestartGatewayResponse:
        names = [gateway.name for gateway in self._plan.gateways]
        if (name := request.gateway) not in names:
            all_names = ", ".join(names) or "none"
            problem = f"there is no gateway {name!r}; {did_you_mean(name, names, f'known are {all_names}')}"
            return RestartGatewayResponse(success=False, message=problem)
        self.supervisor.restart(f"gateway/{name}")
        return RestartGatewayResponse(success=True, message=f"gateway {name} starts again")

    def _beside_index(self, name: str) -> Path | None:
        return self.index_file and self.index_file.with_name(name) if self._plan.discovery.persist else None

    def _serve_copies(self, main: Node) -> None:
        from homebot.runtime.saved_files import serve_copies  # noqa: PLC0415 - few runs are asked

        index = self._beside_index(JOURNAL_FILE)
        serve_copies(main, index and index.parent)

    async def _directory(self, *, task_status: TaskStatus[None]) -> None:
        async with Node(self.graph, "discovery") as node:
            self._owner = OwnerFacts(self._plan.home, self._plan.places, self._clock.now())
            control = self._plan.control  # None means the defaults, which are not loaded just for this
            needs_approval = not self._approves_all and (control is None or control.approvals)
            settings, file = self._plan.discovery, self.index_file
            limits, known = self._plan.limits, self.known
            self._index = Directory(
                node, settings, file, self._owner, needs_approval=needs_approval, limits=limits, known=known
            )
            await run_as(node.full_name, partial(self._index.serve, task_status=task_status))

    async def _control(self, *, task_status: TaskStatus[None]) -> None:
        async with Node(self.graph, "control") as node:
            self._controller = Control(
                node,
                self._plan.control,
                self._plan.grants,
                trusts_apps=self.trusts_apps,
                approves_all=self._approves_all,
                journal_file=self._beside_index(JOURNAL_FILE),
                rehearsal=self.rehearsal,
                detected=self.detected,
                scopes=lambda: self._plan.scopes,
            )
            await run_as(node.full_name, partial(self._controller.serve, task_status=task_status))

    async def _feature(self, feature: Feature, *, task_status: TaskStatus[None]) -> None:
        async with Node(self.graph, feature.name) as node:

            @cache
            def server() -> FeatureServer:
                made: FeatureServer = load(feature.server)(node, self._feature_context)
                return made

            for service in feature.services:
                if not service.ros_type:
                    continue
                offer = node.offer_action if "/action/" in service.ros_type else node.offer_service
                start = partial(lambda name: server().serve(name), service.name)
                offer(service.ros_type, service.name, start, partial(load, feature.server))
            self._servers[feature.name] = server
            task_status.started()  # before anything of it is loaded, as its mistakes stop nothing else
            if any(map(self.app_host.has_kept, feature.stores)):
                server()
            await anyio.sleep_forever()

    @cached_property
    def _feature_context(self) -> FeatureContext:
        from homebot.feature_context import FeatureContext  # noqa: PLC0415 - few features are used

        return FeatureContext(
            graph=self.graph,
            keeps_data=self.index_file is not None or self.house is not None,
            is_rehearsal=self.is_dry_run or self.rehearsal is not None,
            home=self.config.home,
            zone=self.app_host.context.zone,
            file=self._beside_index,
            apps=self.app_manager,
            run_facts=self._run_facts,
            run_app=self._run_app,
            control=lambda: self._controller,
            directory=lambda: self._index,
            table=lambda key: self._plan.features.get(key),  # noqa: PLW0108 - a reload replaces the plan
            store=self.app_host.store,
            config_file=lambda: self.config.file,
            write_stores=self.app_host.write_stores,
            notify=self.app_host.context.notify,
            random=self._context.random or Random(),  # noqa: S311 - no secret
            began_at=self.app_host.began_at,
            restart=self.restart,
        )

    def _greet(self) -> None:
        plan = self._plan
        greeting = plan.greeting(None if self.rosbridge is None else self.rosbridge.page, is_dry_run=self.is_dry_run)
        _log.info(RUNNING, message=greeting, gateways=len(plan.gateways), apps=len(plan.apps))
        text = plan.as_other_machine or self.app_manager.running_text(self.app_manager.apps)
        _log.info(APPS, message=text, names=[app.name for app in plan.apps])
        if self.show_code is not None and self._first_code is not None and self.rosbridge is not None:
            self.show_code(self.rosbridge.page, self._first_code.secret.get_secret_value())

    async def _run_feature(self, feature: Feature, *, task_status: TaskStatus[None]) -> None:
        task_status.started()
        names = {service.name for service in feature.services}
        self.graph.coming |= names
        try:
            await anyio.sleep(_LATER)
            run = await load_beside_loop(partial(load, feature.runs))
            await run(self._feature_context)
        finally:
            self.graph.coming -= names

    async def _run_app(self, name: str, kind: type[App], settings: BaseModel) -> None:
        component = PlannedComponent(name, kind, settings)
        await self.app_host.serve(component, task_status=anyio.TASK_STATUS_IGNORED)

    async def _run_facts(self) -> RecordingHeader:
        from homebot.runtime.run_facts import run_facts  # noqa: PLC0415 - few runs are recorded

        detected = () if self._controller is None else await self._controller.detected()
        return run_facts(self._plan, detected, trusts_apps=self.trusts_apps, approves_all=self._approves_all)

    async def _rosapi(self, *, task_status: TaskStatus[None]) -> None:
        from homebot.bridges.rosapi import RosApi  # noqa: PLC0415 - see where it is started

        async with Node(self.graph, "rosapi") as node:
            RosApi(node, frozenset(robot.vacuum for robot in self._plan.robots.values()))
            task_status.started()
            await anyio.sleep_forever()

    async def _serve_rosbridge(self, *, task_status: TaskStatus[None]) -> None:
        async with Node(self.graph, "rosbridge_websocket") as node:
            announce = self._network_services.publish
            owner = None if self._local_rights is SIMULATED_HOUSE_RIGHTS else await self._owner_token()
            owners, home = self._plan.robot_owners, self._plan.home
            if self.show_code is not None and owner is not None and self._plan.door.is_for_owner(owner.secret):
                from homebot.bridges.rosbridge.first_code import FirstCode  # noqa: PLC0415 - for a new home alone

                self._first_code = FirstCode(self._clock)
            folder = None if self.owner_file is None else self.owner_file.with_name("door")
            site = partial(_page, folder if self._plan.door.tls else None)
            self.rosbridge = RosbridgeServer(
                node,
                self._plan.door,
                announce,
                self._local_rights,
                owners,
                home,
                site=site,
                owner=owner,
                tls_folder=folder,
                first_code=self._first_code,
            )
            node.create_service(GetHealth, "~/health", self.rosbridge.health)
            node.create_service(ListTokens, LIST_TOKENS, self.rosbridge.list_tokens)
            await run_as(node.full_name, partial(self.rosbridge.run, task_status=task_status))

    async def _owner_token(self) -> OwnerToken | None:
        if self.owner_file is None:
            return None
        try:
            return await to_thread.run_sync(make_owner_token, self.owner_file)
        except UsageError as exc:
            _log.warning(NO_OWNER, message=f"the command line can only read and give harmless commands: {exc}")
            return None


async def _page(
    folder: Path | None, path: str, etag: str, encodings: str
) -> tuple[HTTPStatus, Mapping[str, str], bytes] | None:
    return await to_thread.run_sync(_read_page, folder, path, etag, encodings)


def _read_page(
    folder: Path | None, path: str, etag: str, encodings: str
) -> tuple[HTTPStatus, Mapping[str, str], bytes] | None:
    from homebot.web.site import answer  # noqa: PLC0415 - with the first browser

    return answer(path, etag, encodings, folder)
