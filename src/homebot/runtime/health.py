"""``/homebot/health``: crashes, failed callbacks, a blocked event loop and lost messages of this process."""

from collections.abc import Callable, Iterator
from pathlib import Path

from anyio import to_thread

from homebot.devices.app_messages import ChangeAppResponse
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse, PartFailure
from homebot.devices.names import RUNTIME_HEALTH
from homebot.graph import Graph, Node, Subscription
from homebot.messages.builtin_interfaces import Time
from homebot.runtime.app_host import AppHost
from homebot.runtime.supervisor import Supervisor
from homebot.support.counters import Severity
from homebot.support.production_loop import LoopWatch

_LONG = 300.0
"""Seconds for which a handler may continue after its caller has left; commissioning a device takes three minutes."""


class RuntimeHealth:
    """Reports the health of the runtime."""

    def __init__(
        self,
        node: Node,
        home: str,
        supervisor: Supervisor,
        watch: LoopWatch | None,
        lost_lines: Callable[[], int],
        apps: AppHost,
        reloaded: Callable[[], ChangeAppResponse],
        folder: Path | None,
    ) -> None:
        self._graph: Graph = node.graph
        self._home = home
        self._supervisor = supervisor
        self._watch = watch
        self._lost_lines = lost_lines
        self._apps = apps
        self._reloaded = reloaded
        self._folder = folder
        node.create_service(GetHealth, RUNTIME_HEALTH, self._answer)

    async def _answer(self, _request: HealthRequest) -> HealthResponse:
        crashes = self._supervisor.crashes.values()
        counts = {
            "components_crashed": len(crashes),
            "components_given_up": len(self._supervisor.given_up),
            "crashes": sum(crash.count for crash in crashes),
            "callback_failures": sum(
                failure.count for failure in self._graph.failures
            ),  # each is among the failures too
            "loop_blocks": 0 if self._watch is None else self._watch.blocks,
            "task_exits": 0 if self._watch is None else self._watch.exits,
        }
        losses = {
            "log_lines_lost": self._lost_lines(),
            "messages_lost": self._graph.failures.messages_lost + sum(self._losses()),
        }
        faults = {
            "answers_late": self._graph.failures.late_answers,
            "calls_refused": self._graph.failures.refused_calls,
        }
        return HealthResponse(
            counts=(
                *Count.each(counts),
                *Count.each(losses, Severity.LOSS),
                *Count.each(faults, Severity.FAULT),
                *self._apps.counts(),
            ),
            troubles=(*self._problems(), *[name async for name in self._apps.unknown_names()]),
            failures=tuple(self._failures()),
            notes=await to_thread.run_sync(self._notes),
            home=self._home,
            build=await to_thread.run_sync(_page_build),
        )

    def _notes(self) -> tuple[str, ...]:
        from homebot.runtime.home_folder import unused_folders  # noqa: PLC0415 - few runs are asked

        return () if self._folder is None else tuple(unused_folders(self._folder))

    def _problems(self) -> Iterator[str]:
        for name, crash in sorted(self._supervisor.crashes.items()):
            if crash.state == "restarting":
                yield f"{name} crashed ({crash.last}) and will be restarted"
        if not self._reloaded().success:
            yield f"the last reload was refused: {self._reloaded().message}"
        yield from self._apps.problems()
        for service, seconds in self._graph.handlers_without_caller():
            if seconds >= _LONG:
                why = "its caller gave up, and later calls may wait for it"
                yield f"a handler of {service} has been running for {seconds / 60:.0f} minutes: {why}"

    def _failures(self) -> Iterator[PartFailure]:
        for name, crash in sorted(self._supervisor.crashes.items()):
            yield _failure(name, "crashed", crash.count, crash.at, crash.last, crash.state)
        given_up = self._apps.given_up()
        for failure in self._graph.failures:
            outcome = "given up" if (failure.node, failure.callback) in given_up else ""
            yield _failure(
                failure.node.lstrip("/"),
                f"the {failure.callback} failed",
                failure.count,
                failure.at,
                failure.last,
                outcome,
            )
        now, watch = self._graph.clock.now(), self._watch
        if watch is not None and watch.blocks:
            at = now - watch.seconds_since_block()
            why = f"by {watch.last}; the longest took {watch.longest:.1f} s"
            yield _failure("event loop", "was blocked", watch.blocks, at, why)
        if watch is not None and watch.exits:
            yield _failure("event loop", "called exit", watch.exits, now - watch.seconds_since_exit(), watch.exited)

    def _losses(self) -> Iterator[int]:
        """Return the losses of the open subscriptions; those of the rosbridge server's clients count their own."""
        for name in self._graph.get_node_names():
            node = self._graph.get_node(name)
            for entity in () if node is None else node.entities:
                if isinstance(entity, Subscription):
                    yield entity.losses


def _page_build() -> str:
    from homebot.web.site import build  # noqa: PLC0415 - few runs are asked

    return build()


def _failure(part: str, what: str, count: int, at: float, why: str, outcome: str = "") -> PartFailure:
    return PartFailure(part=part, what=what, count=count, last=Time.from_seconds(at), why=why, outcome=outcome)
