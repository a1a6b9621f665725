"""Quality of service in tokens of rmw_zenoh."""

import pytest

from homebot.bridges.zenoh.qos_text import qos_from_text, qos_to_text
from homebot.errors import TypeMismatchError
from homebot.graph.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    qos_profile_latched,
    qos_profile_sensor_data,
)


@pytest.mark.parametrize(
    ("qos", "text"),
    [
        (QoSProfile(), "::,10:,:,:,,"),
        (qos_profile_latched, ":1:,1:,:,:,,"),
        (qos_profile_sensor_data, "2::,5:,:,:,,"),
        (QoSProfile(history=HistoryPolicy.KEEP_ALL), "::2,10:,:,:,,"),
        (
            QoSProfile(
                deadline=1.5,
                lifespan=2.0,
                liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
                liveliness_lease_duration=0.25,
            ),
            "::,10:1,500000000:2,0:3,0,250000000",
        ),
    ],
)
def test_it_is_written_and_read_as_ros_2_does(qos: QoSProfile, text: str) -> None:
    assert qos_to_text(qos) == text
    assert qos_from_text(text) == qos


@pytest.mark.parametrize(
    ("text", "qos"),
    [
        ("::,:,:,:,,", QoSProfile()),
        ("1:2:1,10:0,0:0,0:1,0,0", QoSProfile()),
        ("::,0:,:,:,,", QoSProfile(depth=1)),
        ("::,4000000000:,:,:,,", QoSProfile(depth=1000)),
        (":1:,:9223372036,854775807:,:,,", QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL)),
    ],
)
def test_other_spellings_are_read(text: str, qos: QoSProfile) -> None:
    assert qos_from_text(text) == qos


@pytest.mark.parametrize(
    "text",
    ["", "::,10", "9::,10:,:,:,,", "x::,10:,:,:,,", "::,10:,:,:,,:", f"::,{2**64}:,:,:,,", f"::,10:,{10**400}:,:,,"],
)
def test_what_has_another_form_is_refused(text: str) -> None:
    with pytest.raises(TypeMismatchError, match="no quality of service"):
        qos_from_text(text)
