"""The base of apps: ready at once, over when run() is; settings are the app's own."""

import anyio
import anyio.lowlevel
import pytest
from pydantic import BaseModel

from homebot.apps import App, NoSettings
from homebot.config import parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.graph import Graph, Node


class Greeting(BaseModel):
    greeting: str = "hello"


class Greeter(App[Greeting]):
    """Says hello once."""

    def __init__(self, node: Node, settings: Greeting) -> None:
        super().__init__(node, settings)
        self.said: list[str] = []

    async def run(self) -> None:
        self.said.append(self.settings.greeting)


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


async def test_an_app_ends_when_its_tasks_have_ended() -> None:
    """What was begun is finished, also after run() returned."""

    class Later(App):
        async def run(self) -> None:
            self.start_task(self.later)

        async def later(self) -> None:
            await anyio.lowlevel.checkpoint()
            done.append("later")

    done: list[str] = []
    async with Node(Graph(), "later") as node:
        app = Later(node, NoSettings())
        with pytest.raises(UsageError, match=r"/later does not run yet; start its tasks in run\(\)"):
            app.start_task(app.later)
        await app.serve()
    assert done == ["later"]


def test_the_settings_of_a_derived_app_are_those_of_its_base() -> None:
    """A model is named once."""

    class Loud(Greeter):
        """An app derived from one with settings."""

    assert (Greeter.Settings, Loud.Settings, App.Settings) == (Greeting, Greeting, NoSettings)
