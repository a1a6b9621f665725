"""Tokens of ROS 2 nodes on Zenoh: those that rmw_zenoh and pyzeros write, with their gids."""

from dataclasses import replace

import pytest

from homebot.bridges.zenoh.tokens import EntityToken, data_key, gid_of
from homebot.errors import HomebotError, TypeMismatchError
from homebot.graph.endpoint import EndpointInfo, EntityKind
from homebot.graph.qos import QoSProfile, qos_profile_sensor_data
from homebot.messages import String
from homebot.messages.type_hash import type_hash

STRING = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
NODE = "@ros2_lv/0/1a2b3c/0/0/NN/%/%/homebot"
PUBLISHER = f"@ros2_lv/0/1a2b3c/0/1/MP/%/%/homebot/%house%events/std_msgs::msg::dds_::String_/{STRING}/::,10:,:,:,,"
SUBSCRIPTION = f"@ros2_lv/0/1a2b3c/0/1/MS/%/%a/homebot/%chatter/std_msgs::msg::dds_::String_/{STRING}/2::,5:,:,:,,"


@pytest.mark.parametrize(
    ("text", "gid", "info"),
    [
        (NODE, "633301181e8976603f25942eef6c8e75", EndpointInfo(EntityKind.NODE, "/homebot", "/homebot")),
        (
            PUBLISHER,
            "3fc83f5bec8a7098e1a1b19126357718",
            EndpointInfo(EntityKind.PUBLISHER, "/homebot", "/house/events", "std_msgs/msg/String", QoSProfile()),
        ),
        (
            SUBSCRIPTION,
            "224eff10086d0fcc2019f9502782c3d4",
            EndpointInfo(
                EntityKind.SUBSCRIPTION, "/a/homebot", "/chatter", "std_msgs/msg/String", qos_profile_sensor_data
            ),
        ),
    ],
    ids=["node", "publisher", "subscription"],
)
def test_a_token_is_read_and_written_and_has_the_gid_of_ros_2(text: str, gid: str, info: EndpointInfo) -> None:
    token = EntityToken.of_text(text)
    assert token.info == info
    assert token.session == "1a2b3c"
    assert token.text == text
    assert token.gid.hex() == gid_of(text).hex() == gid


def test_the_hash_in_a_token_is_that_of_the_type() -> None:
    assert EntityToken.of_text(PUBLISHER).type_hash == type_hash(String)


def test_the_key_of_data_keeps_the_slashes_inside_the_name() -> None:
    expected = f"0/house/events/std_msgs::msg::dds_::String_/{STRING}"
    assert EntityToken.of_text(PUBLISHER).key == data_key(0, "/house/events", "std_msgs/msg/String", STRING) == expected


def test_parts_that_newer_versions_append_are_ignored() -> None:
    assert EntityToken.of_text(f"{PUBLISHER}/cpu:1/more") == EntityToken.of_text(PUBLISHER)


def test_a_service_has_no_quality_of_service_in_the_graph() -> None:
    text = PUBLISHER.replace("/MP/", "/SS/").replace("msg::dds_::String_", "srv::dds_::Trigger_")
    token = EntityToken.of_text(text)
    assert (token.info.kind, token.info.ros_type, token.info.qos) == (EntityKind.SERVICE, "std_msgs/srv/Trigger", None)
    assert token.text == text
    assert replace(token, domain=7).text.startswith("@ros2_lv/7/")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "@ros2_lv",
        NODE.replace("NN", "XX"),
        NODE.replace("@ros2_lv", "@ros3_lv"),
        NODE.replace("/0/0/", "/0/x/"),
        NODE.replace("homebot", ""),
        NODE.replace("homebot", "home-bot"),
        PUBLISHER.removesuffix("/::,10:,:,:,,"),
        PUBLISHER.replace("::,10:,:,:,,", ":,10"),
        PUBLISHER.replace("dds_::String_", "String"),
        PUBLISHER.replace("std_msgs::msg::dds_::String_", "String"),
        PUBLISHER.replace("%house%events", "%house%%events"),
        PUBLISHER.replace("%house%events", "%house%\n<b>"),
        PUBLISHER + "/more" * 1000,
    ],
)
def test_what_is_no_token_is_refused_in_words(text: str) -> None:
    with pytest.raises(HomebotError, match=r"no token|no quality|no type|node name|name in a token"):
        EntityToken.of_text(text)


@pytest.mark.parametrize("cut", range(len(PUBLISHER) - 2))
def test_a_token_cut_anywhere_is_refused(cut: int) -> None:
    with pytest.raises(TypeMismatchError):
        EntityToken.of_text(PUBLISHER[:cut])
