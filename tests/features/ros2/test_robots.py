"""The robots on the wire: the names that come from them, and their rights."""

from pathlib import Path

import pytest

from homebot.bridges.rosbridge import ClientToken, RosbridgeSettings
from homebot.bridges.zenoh.logins import login_notes, logins_of
from homebot.devices.robot_owners import RobotOwners
from homebot.errors import ConfigError, PeerError, UsageError
from homebot.features.ros2.robots import RobotsOnWire
from homebot.messages.interfaces.settings import RosSettings, read_interfaces

OWNERS = RobotOwners({"rosie": (), "bob": ()})


def door(*robots: str) -> RosbridgeSettings:
    tokens = {f"{one}_brain": ClientToken(token=f"secret of {one}", scope=("read", f"robot: {one}")) for one in robots}
    return RosbridgeSettings(tokens=tokens)


def test_what_comes_from_a_robot_has_the_rights_of_its_token() -> None:
    robots = RobotsOnWire.of({"rosie": ("/rosie/**",)}, door("rosie"), OWNERS)
    source = robots.source_of("/rosie/pose")
    assert source is not None
    assert (source.name, source.rights.robots) == ("rosie_brain", ("rosie",))
    assert robots.source_of("/bob/pose") is None
    assert robots.caller("/anything") is source


def test_a_robot_needs_a_token() -> None:
    with pytest.raises(UsageError, match="homebot token new bob --scope read --scope 'robot: bob'"):
        RobotsOnWire.of({"bob": ("/bob/**",)}, door("rosie"), OWNERS)


@pytest.mark.parametrize(
    ("table", "scopes", "logins", "missing"),
    [
        ({"import": {"rosie": ["/rosie/**"]}}, {"rosie": ["read", "robot: rosie"]}, ("rosie",), []),
        ({}, {"rosie": ["read"]}, (), ["no robot may log in at tcp/127.0.0.1:7447; that takes import = "]),
        (
            {"import": {"bob": ["/bob/**"]}},
            {"bob": ["robot: bob"], "rosie": ["read", "robot: rosie"], "tablet": ["read"]},
            ("bob",),
            [
                "bob sees nothing of export at tcp/127.0.0.1:7447: its token lacks the right read",
                "the token rosie is no login at tcp/127.0.0.1:7447: import of [ros] names no rosie",
            ],
        ),
        (
            {"import": {"bob": ["/bob/**"]}},
            {"bob": ["read", "robot: bob"], "second": ["read", "robot: bob"]},
            ("bob",),
            ["the token second is no login at tcp/127.0.0.1:7447: bob logs in as bob"],
        ),
    ],
)
def test_who_may_log_in_at_the_router_and_what_is_missing_is_told(
    table: dict[str, object], scopes: dict[str, tuple[str, ...]], logins: tuple[str, ...], missing: list[str]
) -> None:
    listen = {"listen": "tcp/127.0.0.1:7447", "export": ["/map"]}
    settings = RosSettings.model_validate(listen | table)
    tokens = {name: ClientToken(token=f"secret of {name}", scope=scope) for name, scope in scopes.items()}
    door = RosbridgeSettings(tokens=tokens)
    assert logins_of(settings, door) == logins
    found = [*login_notes(settings, door)]
    assert [one[: len(start)] for one, start in zip(found, missing, strict=True)] == missing
    assert [*login_notes(settings.model_copy(update={"listen": ""}), door)] == []


def test_the_rights_end_with_the_token() -> None:
    token = ClientToken(token="secret", scope=("read", "robot: rosie"), until=100.0)
    times = [99.0]
    robots = RobotsOnWire.of(
        {"rosie": ("/rosie/**",)}, RosbridgeSettings(tokens={"rosie": token}), OWNERS, lambda: times[-1]
    )
    assert robots.source_of("/rosie/pose") is robots.caller("/rosie/nav") is not None
    times.append(100.0)
    assert robots.source_of("/rosie/pose") is None
    with pytest.raises(PeerError, match="the token rosie has ended"):
        robots.caller("/rosie/nav")
    assert [one.partition(";")[0] for one in robots.problems()] == [
        "nothing is taken from rosie: the token rosie has ended"
    ]


def test_of_several_robots_each_calls_from_its_namespace() -> None:
    robots = RobotsOnWire.of({"rosie": ("/rosie/**",), "bob": ("/bob/**",)}, door("rosie", "bob"), OWNERS)
    assert robots.caller("/bob/nav/planner").name == "bob_brain"
    for node in ("/planner", "", "/rosie2/nav"):
        with pytest.raises(PeerError, match="belongs to no robot"):
            robots.caller(node)


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"connect": ["tcp/robot.lan:7447"]}, "use tls/"),
        ({"connect": ["robot.lan"]}, "no address of Zenoh"),
        ({"listen": "tcp/0.0.0.0:7447"}, "use tls/"),
        ({"listen": "tls/0.0.0.0:7447"}, "needs cert_file and key_file; make them: homebot router --certificate"),
        ({"connect": ["tls/robot.lan:7447"], "user": "house"}, "give user and password_file together"),
        ({"export": ["map"]}, "no name of topics"),
        ({"import": {"rosie": ["/a b"]}}, "no name of topics"),
        ({"domain": 233}, "232"),
    ],
)
def test_a_link_that_others_could_change_or_that_is_misspelt_is_refused(table: dict[str, object], problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        read_interfaces(table, "homebot.toml", Path())


def test_without_an_address_there_is_no_link() -> None:
    assert not RosSettings().has_link
    assert RosSettings.model_validate({"listen": "tcp/127.0.0.1:7447"}).has_link
