"""The base of apps: ready at once, over when run() is; settings are the app's own."""

from __future__ import annotations

import anyio
import pytest
from pydantic import BaseModel

from homebot.apps import App, NoSettings
from homebot.config import parse_settings
from homebot.errors import ConfigError
from homebot.graph import Graph, Node


class Greeting(BaseModel):
    greeting: str = "hello"


class Greeter(App):
    """Says hello once."""

    Settings = Greeting
    said: list[str]

    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        assert isinstance(settings, Greeting)
        self._greeting = settings.greeting
        self.said = []

    async def run(self) -> None:
        self.said.append(self._greeting)


async def test_an_app_is_ready_before_it_runs_and_done_when_run_returns() -> None:
    """Readiness does not wait for what the app is for."""
    async with Node(Graph(), "greeter") as node, anyio.create_task_group() as tasks:
        greeter = Greeter(node, Greeting(greeting="good morning"))
        await tasks.start(greeter.serve)
    assert greeter.said == ["good morning"]


async def test_an_app_without_run_cannot_be_made() -> None:
    """The author hears of it at once."""
    with pytest.raises(TypeError, match="run"):
        App(Node(Graph(), "app"), NoSettings())  # type: ignore[abstract]  # what is under test


def test_an_app_without_settings_takes_none() -> None:
    """A key that nobody reads is a mistake."""
    with pytest.raises(ConfigError, match=r"apps\.light\.colour: unknown key; known are none"):
        parse_settings(NoSettings, {"colour": "red"}, "homebot.toml", "apps.light")
