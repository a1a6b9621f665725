"""Quality of service: profiles, and which offer fits which request."""

from dataclasses import replace

import pytest

from homebot.errors import QosError
from homebot.graph import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_incompatibilities,
    qos_profile_default,
    qos_profile_latched,
    qos_profile_rosout,
    qos_profile_sensor_data,
    qos_profile_services_default,
)
from homebot.graph.qos import to_qos_profile

BEST_EFFORT = QoSProfile(reliability=ReliabilityPolicy.BEST_EFFORT)
TRANSIENT_LOCAL = QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL)
MANUAL = QoSProfile(liveliness=LivelinessPolicy.MANUAL_BY_TOPIC)
DEFAULT = QoSProfile()


@pytest.mark.parametrize(
    ("offered", "requested", "problem"),
    [
        (BEST_EFFORT, DEFAULT, "reliability: best effort is offered, reliable is requested"),
        (DEFAULT, TRANSIENT_LOCAL, "durability: volatile is offered, transient local is requested"),
        (DEFAULT, QoSProfile(deadline=1), "deadline: the offered one is longer than the requested one"),
        (QoSProfile(deadline=2), QoSProfile(deadline=1), "deadline: the offered one is longer than the requested one"),
        (DEFAULT, MANUAL, "liveliness: automatic is offered, manual by topic is requested"),
        (
            DEFAULT,
            QoSProfile(liveliness_lease_duration=1),
            "liveliness lease: the offered one is longer than the requested one",
        ),
    ],
)
def test_a_weaker_offer_does_not_fit(offered: QoSProfile, requested: QoSProfile, problem: str) -> None:
    assert qos_incompatibilities(offered, requested) == (problem,)


@pytest.mark.parametrize(
    ("offered", "requested"),
    [
        (DEFAULT, DEFAULT),
        (DEFAULT, BEST_EFFORT),
        (BEST_EFFORT, BEST_EFFORT),
        (TRANSIENT_LOCAL, DEFAULT),
        (TRANSIENT_LOCAL, TRANSIENT_LOCAL),
        (QoSProfile(deadline=1), QoSProfile(deadline=1)),
        (QoSProfile(deadline=1), QoSProfile(deadline=2)),
        (QoSProfile(deadline=1), DEFAULT),
        (MANUAL, DEFAULT),
        (QoSProfile(depth=1, lifespan=1), QoSProfile(history=HistoryPolicy.KEEP_ALL)),
    ],
)
def test_an_offer_that_is_as_strong_fits(offered: QoSProfile, requested: QoSProfile) -> None:
    assert qos_incompatibilities(offered, requested) == ()


def test_every_mismatch_is_named() -> None:
    requested = QoSProfile(durability=DurabilityPolicy.TRANSIENT_LOCAL, deadline=1)
    assert len(qos_incompatibilities(BEST_EFFORT, requested)) == 3


def test_a_number_is_a_depth() -> None:
    assert to_qos_profile(3) == QoSProfile(depth=3)
    assert to_qos_profile(BEST_EFFORT) is BEST_EFFORT


@pytest.mark.parametrize("depth", [0, -1])
def test_a_depth_below_one_is_refused(depth: int) -> None:
    with pytest.raises(QosError, match=f"depth must be at least 1, got {depth}"):
        to_qos_profile(depth)


@pytest.mark.parametrize("name", ["lifespan", "deadline", "liveliness_lease_duration"])
def test_negative_seconds_are_refused(name: str) -> None:
    with pytest.raises(QosError, match="cannot be negative"):
        replace(DEFAULT, **{name: -0.1})  # type: ignore[arg-type]  # mypy cannot see which field it is


def test_keep_all_is_bounded() -> None:
    assert QoSProfile(depth=1, history=HistoryPolicy.KEEP_ALL).queue_depth == 65_536


def test_the_presets_are_those_of_ros() -> None:
    assert qos_profile_default == qos_profile_services_default == QoSProfile(depth=10)
    assert (qos_profile_sensor_data.depth, qos_profile_sensor_data.reliability) == (5, ReliabilityPolicy.BEST_EFFORT)
    assert (qos_profile_rosout.depth, qos_profile_rosout.lifespan) == (1000, 10.0)
    assert qos_profile_latched.durability is qos_profile_rosout.durability is DurabilityPolicy.TRANSIENT_LOCAL
    assert qos_profile_latched.depth == 1


def test_the_numbers_are_those_on_the_wire_of_ros() -> None:
    assert (HistoryPolicy.KEEP_LAST, HistoryPolicy.KEEP_ALL) == (1, 2)
    assert (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT) == (1, 2)
    assert (DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE) == (1, 2)
    assert (LivelinessPolicy.AUTOMATIC, LivelinessPolicy.MANUAL_BY_TOPIC) == (1, 3)
