"""Settings of gateways and apps as parameters."""

import pytest
from pydantic import BaseModel, Field, SecretStr

from homebot.apps.follow_me import FollowMeSettings
from homebot.config import parse_config
from homebot.errors import ParameterError
from homebot.gateways.mqtt.settings import MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.runtime import Runtime
from homebot.runtime.settings_parameters import declare_settings


class Limits(BaseModel):
    """Limits.

    Attributes:
        most: The most lamps
            that are on.
    """

    most: int = 3


class Settings(BaseModel):
    """Settings of many kinds."""

    limits: Limits = Limits()
    token: SecretStr = SecretStr("hunter2")
    key: str = Field("hunter2", repr=False)
    numbers: tuple[float, ...] = (1.0, 2.5)
    tables: tuple[Limits, ...] = (Limits(),)
    unset: str | None = None


async def test_tables_have_names_with_dots_and_secrets_are_left_out() -> None:
    node = Node(Graph(), "app")
    declare_settings(node, Settings())
    assert {name: node.get_parameter(name).value for name in node.parameters.names()} == {
        "limits.most": 3,
        "numbers": (1.0, 2.5),
    }
    assert node.parameters.describe("limits.most")[1].description == "The most lamps that are on."


async def test_the_login_in_an_address_is_left_out_and_descriptions_come_from_the_docstrings() -> None:
    node = Node(Graph(), "mqtt", namespace="/gateway")
    declare_settings(node, MqttGatewaySettings(url="mqtt://tom:hunter2@broker:1883"))
    assert node.get_parameter("url").value == "mqtt://broker:1883"
    assert node.parameters.describe("stale_after")[1] == (
        "Seconds of silence after which a device counts as stale.",
        True,
        None,
        None,
    )


async def test_the_name_at_the_broker_is_left_out_as_it_takes_over_the_session() -> None:
    node = Node(Graph(), "mqtt", namespace="/gateway")
    declare_settings(node, MqttGatewaySettings())
    assert "client_id" not in node.parameters.names()


async def test_an_app_in_a_running_homebot_has_its_settings_as_parameters_that_stay() -> None:
    config = parse_config({"apps": {"follow_me": {"dark_below": 20.0}}}, "test")
    async with Runtime(config, with_door=False) as runtime:
        node = runtime.graph.get_node("/follow_me")
        assert node is not None
        assert node.parameters.names() == tuple(sorted(FollowMeSettings.model_fields))
        assert node.get_parameter("dark_below").value == 20.0
        with pytest.raises(ParameterError, match="'dark_below' is read-only"):
            node.parameters.set("dark_below", 10.0)
