"""What gateways need in this process: started once for all, found by its class, stopped after them."""

import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import ClassVar

import anyio
import pytest
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.clock import Clock
from homebot.config import Config, parse_config
from homebot.errors import ConfigError
from homebot.gateways import Gateway, GatewayContext, HostService
from homebot.graph import Graph
from homebot.house import thesis_world
from homebot.runtime import Runtime

LINES: list[str] = []


class Radio:
    """The service."""

    def __init__(self, name: str) -> None:
        self.name = name


@asynccontextmanager
async def radio(graph: Graph, clock: Clock) -> AsyncIterator[Radio]:
    del graph, clock
    LINES.append("radio on")
    yield Radio("started")
    LINES.append("radio off")


class RadioSettings(BaseModel):
    """What the gateway takes from the radio."""

    radio: str = ""


class RadioGateway(Gateway):
    """Needs the radio."""

    Settings: ClassVar[type[BaseModel]] = RadioSettings

    @classmethod
    def host_services(cls, settings: BaseModel) -> tuple[HostService[object], ...]:
        del settings
        return (HostService(Radio, radio),)

    @classmethod
    def resolve(cls, settings: BaseModel, context: GatewayContext) -> BaseModel:
        found = context.service(Radio)
        return settings.model_copy(update={"radio": "none" if found is None else found.name})

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        found = self.context.service(Radio)
        LINES.append(f"{self.node.name} has {'none' if found is None else found.name}")
        task_status.started()
        try:
            await anyio.sleep_forever()
        finally:
            LINES.append(f"{self.node.name} stops")


class DeafGateway(RadioGateway):
    """Needs another radio, of the same class."""

    @classmethod
    def host_services(cls, settings: BaseModel) -> tuple[HostService[object], ...]:
        del settings
        return (HostService(Radio, partial(radio)),)


class WatchingGateway(RadioGateway):
    """Needs the radio, and looks at which gateways are configured."""

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        LINES.append(f"{self.node.name} sees {', '.join(sorted(self.context.gateways or ()))}")
        await super().serve(task_status=task_status)


@pytest.fixture(autouse=True)
def _importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """As ``module:Class`` is looked up: by the name of the module."""
    monkeypatch.setitem(sys.modules, __name__, sys.modules[__name__])
    LINES.clear()


def config(*names: str) -> Config:
    table = {"class": f"{__name__}:{RadioGateway.__name__}"}
    return parse_config({"gateways": dict.fromkeys(names, table)}, "test")


async def test_a_service_starts_once_for_all_gateways_and_stops_after_them() -> None:
    async with Runtime(config("first", "second"), with_door=False) as runtime:
        service = runtime.service(Radio)
        assert service is not None
        assert service.name == "started"
    assert LINES[:3] == ["radio on", "first has started", "second has started"]
    assert sorted(LINES[3:5]) == ["first stops", "second stops"]
    assert LINES[5:] == ["radio off"]


def test_gateways_share_a_service_only_with_the_same_settings_for_it() -> None:
    tables = {**config("first").gateways, "second": {"class": f"{__name__}:DeafGateway"}}
    with pytest.raises(ConfigError, match=r"gateways\.second: it shares what runs with gateways\.first"):
        Runtime(parse_config({"gateways": tables}, "test"), with_door=False)


async def test_a_service_that_is_given_is_used_and_none_is_started() -> None:
    async with Runtime(config("first"), with_door=False, services=[Radio("given")]):
        pass
    assert LINES == ["first has given", "first stops"]


async def test_what_nobody_needs_is_not_started() -> None:
    async with Runtime(parse_config({}, "test"), with_door=False) as runtime:
        assert runtime.service(Radio) is None
    assert LINES == []


async def test_a_gateway_knows_which_others_are_configured() -> None:
    """By their plug-ins, whatever names they have."""
    tables = {"first": {"class": f"{__name__}:WatchingGateway"}, **config("second", "third").gateways}
    async with Runtime(parse_config({"gateways": tables}, "test"), with_door=False):
        pass
    assert f"first sees {__name__}:RadioGateway, {__name__}:WatchingGateway" in LINES


def test_a_simulated_house_needs_a_service_that_can_host_it() -> None:
    with pytest.raises(ConfigError, match=r"test: gateways: none uses the embedded broker"):
        Runtime(config("first"), house=thesis_world())
