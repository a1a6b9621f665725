"""Tokens of zenoh-bridge-ros2dds 1.x, in the forms of its ``liveliness_mgt.rs``."""

import pytest

from homebot.bridges.zenoh.bridge_tokens import BridgeToken, entity_texts, token_of_text
from homebot.bridges.zenoh.qos_text import qos_from_bridge
from homebot.bridges.zenoh.tokens import NO_HASH, EntityToken
from homebot.errors import HomebotError, TypeMismatchError
from homebot.graph import EntityKind, QoSProfile, qos_profile_latched
from homebot.graph.endpoint import EndpointInfo
from homebot.graph.qos import HistoryPolicy, ReliabilityPolicy

ID = "a1b2c3d4e5f60718293a4b5c6d7e8f90"
BRIDGE = f"@/{ID}/@ros2_lv"
HASH = f"RIHS01_{'5a' * 32}"
POSE = f"{BRIDGE}/MP/rosie§amcl_pose/geometry_msgs§msg§PoseWithCovarianceStamped/:1:1:0,1:typehash={HASH};"
HUMBLE = f"{BRIDGE}/MP/tf/tf2_msgs§msg§TFMessage/:1:0:0,100"
SERVICE = f"{BRIDGE}/SS/rosie§dock/std_srvs§srv§Trigger"
ACTION = f"{BRIDGE}/AS/rosie§navigate_to_pose/nav2_msgs§action§NavigateToPose"


def test_the_token_of_a_topic_tells_its_key_type_hash_and_quality() -> None:
    token = token_of_text(POSE)
    assert isinstance(token, BridgeToken)
    ros_type = "geometry_msgs/msg/PoseWithCovarianceStamped"
    node = "/rosie/zenoh_bridge_ros2dds"
    kind = EntityKind.PUBLISHER
    assert token.info == EndpointInfo(kind, node, "/rosie/amcl_pose", ros_type, qos_profile_latched)
    assert (token.session, token.key, token.type_hash) == (ID, "rosie/amcl_pose", HASH)
    assert token.cache == f"@/{ID}/@ros2_pub_cache/rosie/amcl_pose"
    assert token.is_bridged


def test_before_iron_there_are_no_hashes_and_a_bridge_without_namespace_adds_none() -> None:
    token = token_of_text(HUMBLE)
    assert (token.info.node, token.info.name, token.type_hash) == ("/zenoh_bridge_ros2dds", "/tf", NO_HASH)


def test_a_service_has_neither_hash_nor_quality() -> None:
    token = token_of_text(SERVICE)
    assert (token.info.kind, token.info.ros_type, token.info.qos) == (EntityKind.SERVICE, "std_srvs/srv/Trigger", None)
    assert (token.key, token.type_hash) == ("rosie/dock", NO_HASH)


def test_an_action_stands_for_its_services_and_topics() -> None:
    tokens = [token_of_text(text) for text in entity_texts(ACTION)]
    assert [(token.key, token.info.ros_type) for token in tokens] == [
        ("rosie/navigate_to_pose/_action/send_goal", "nav2_msgs/action/NavigateToPose_SendGoal"),
        ("rosie/navigate_to_pose/_action/cancel_goal", "action_msgs/srv/CancelGoal"),
        ("rosie/navigate_to_pose/_action/get_result", "nav2_msgs/action/NavigateToPose_GetResult"),
        ("rosie/navigate_to_pose/_action/feedback", "nav2_msgs/action/NavigateToPose_FeedbackMessage"),
        ("rosie/navigate_to_pose/_action/status", "action_msgs/msg/GoalStatusArray"),
    ]
    assert tokens[-1].info.qos == qos_profile_latched


def test_a_bridge_and_what_it_only_uses_stand_for_nothing() -> None:
    for rest in ("", "/MS/cmd_vel/geometry_msgs§msg§Twist/:::", "/SC/dock/std_srvs§srv§Trigger", "/AC/go/a§action§Go"):
        assert entity_texts(f"{BRIDGE}{rest}") == ()


def test_tokens_of_rmw_zenoh_stay_what_they_are() -> None:
    text = "@ros2_lv/0/1a2b3c/0/0/NN/%/%/homebot"
    assert entity_texts(text) == (text,)
    assert token_of_text(text) == EntityToken.of_text(text)
    assert not token_of_text(text).is_bridged


@pytest.mark.parametrize(
    "text",
    [
        "@/",
        f"{BRIDGE}/",
        f"{BRIDGE}/XX/rosie§dock/std_srvs§srv§Trigger",
        POSE.replace("@ros2_lv", "@ros3_lv"),
        POSE.replace(ID, "*"),
        POSE.replace(ID, "a$*"),
        POSE.replace(ID, ""),
        POSE.replace("rosie§amcl_pose", ""),
        POSE.replace("rosie§amcl_pose", "rosie§§amcl_pose"),
        POSE.replace("rosie§amcl_pose", "**"),
        POSE.replace("rosie§amcl_pose", "rosie§$*"),
        POSE.replace("rosie§amcl_pose", "@§rosie"),
        POSE.replace("rosie§amcl_pose", "0§rosie§pose§T§H"),
        POSE.replace("rosie§amcl_pose", "rosie§" + "x" * 300),
        POSE.replace("geometry_msgs§msg§PoseWithCovarianceStamped", "Pose"),
        POSE.replace("geometry_msgs§msg§PoseWithCovarianceStamped", "..§..§passwd"),
        POSE.replace("geometry_msgs§msg§PoseWithCovarianceStamped", "a§msg§b§c"),
        POSE.replace(":1:1:0,1", ":1:1"),
        POSE.replace(":1:1:0,1", ":1:9:0,1"),
        POSE.replace(":1:1:0,1", f":1:1:0,{'9' * 5000}"),
        POSE + "/more",
        SERVICE + "/:::",
        ACTION.replace("rosie§navigate_to_pose", "rosie§{ros_type}"),
        ACTION.replace("nav2_msgs§action§NavigateToPose", ""),
        POSE + "x" * 5000,
    ],
)
def test_what_is_no_token_is_refused_in_words(text: str) -> None:
    with pytest.raises(HomebotError, match=r"no token|no quality|name in a token"):
        [token_of_text(one) for one in entity_texts(text)]


@pytest.mark.parametrize("cut", range(2, POSE.index(":0,1:typehash")))
def test_a_token_cut_anywhere_is_refused_or_stands_for_nothing(cut: int) -> None:
    texts = entity_texts(POSE[:cut])
    if texts:
        with pytest.raises(HomebotError):
            token_of_text(texts[0])


@pytest.mark.parametrize(
    ("text", "qos"),
    [
        (":::", QoSProfile(depth=1)),
        ("K:0:0:0,5", QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)),
        (":1:0:1,-1", QoSProfile(depth=1, history=HistoryPolicy.KEEP_ALL)),
        (":1:0:0,4000000000", QoSProfile(depth=1000)),
    ],
)
def test_the_quality_is_that_of_dds(text: str, qos: QoSProfile) -> None:
    assert qos_from_bridge(text) == (qos, "")
    assert qos_from_bridge(f"{text}:typehash={HASH};more=a:b;") == (qos, f"typehash={HASH};more=a:b;")


@pytest.mark.parametrize("text", ["", "::", "x:1:0:2,1", ":1:0:0", ":1:0:0,x", ":1:0:0,1,2", "2:2:2:2"])
def test_what_is_no_quality_is_refused(text: str) -> None:
    with pytest.raises(TypeMismatchError, match="no quality of service of zenoh-bridge-ros2dds"):
        qos_from_bridge(text)
