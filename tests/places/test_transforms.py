"""Transforms between frames, against vectors of scipy and pytransform3d, and with tf2's rules and texts."""

import json
import math
from pathlib import Path
from typing import Any

import pytest

from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from homebot.messages.std_msgs import Header
from homebot.places.transforms import (
    MAX_DEPTH,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TransformBuffer,
)

VECTORS = json.loads((Path(__file__).parent / "data/tf_vectors.json").read_text())["vectors"]


def stamp(nanoseconds: int) -> Time:
    sec, nanosec = divmod(nanoseconds, 1_000_000_000)
    return Time(sec=sec, nanosec=nanosec)


def seconds(value: float) -> Time:
    return stamp(round(value * 1e9))


def transform(
    parent: str, child: str, at: Time, t: tuple[float, ...] = (1.0, 0.0, 0.0), q: tuple[float, ...] = (0, 0, 0, 1)
) -> TransformStamped:
    x, y, z, w = map(float, q)
    return TransformStamped(
        header=Header(stamp=at, frame_id=parent),
        child_frame_id=child,
        transform=Transform(translation=Vector3(x=t[0], y=t[1], z=t[2]), rotation=Quaternion(x=x, y=y, z=z, w=w)),
    )


def buffer_of(*transforms: TransformStamped) -> TransformBuffer:
    buffer = TransformBuffer()
    for one in transforms:
        buffer.set_transform(one)
    return buffer


@pytest.mark.parametrize("vector", VECTORS, ids=range(len(VECTORS)))
def test_a_looked_up_transform_equals_that_of_other_libraries(vector: dict[str, Any]) -> None:
    buffer = TransformBuffer()
    for one in vector["transforms"]:
        set_it = buffer.set_transform_static if one["static"] else buffer.set_transform
        set_it(transform(one["parent"], one["child"], stamp(one["stamp"]), one["t"], one["q"]))

    found = buffer.lookup_transform(vector["target"], vector["source"], stamp(vector["time"])).transform

    moved, turned = found.translation, found.rotation
    assert (moved.x, moved.y, moved.z) == pytest.approx(vector["t"], abs=1e-9)
    q = (turned.x, turned.y, turned.z, turned.w)
    sign = math.copysign(1.0, sum(a * b for a, b in zip(q, vector["q"], strict=True)))
    assert [sign * one for one in q] == pytest.approx(vector["q"], abs=1e-9)


def test_the_latest_common_time_is_the_oldest_of_the_newest_without_static_frames() -> None:
    buffer = buffer_of(
        transform("map", "odom", seconds(5)),
        transform("odom", "base", seconds(3)),
        transform("odom", "base", seconds(4)),
    )
    buffer.set_transform_static(transform("base", "laser", seconds(0)))
    buffer.set_transform(transform("map", "odom", seconds(4)))

    found = buffer.lookup_transform("map", "laser")

    assert found.header.stamp == seconds(4)
    assert (found.header.frame_id, found.child_frame_id) == ("map", "laser")
    assert found.transform.translation.x == 3.0


def test_a_frame_in_itself_is_the_identity_even_if_nothing_is_known_of_it() -> None:
    assert TransformBuffer().lookup_transform("nope", "nope").transform.rotation.w == 1.0


def test_between_stamps_of_two_parents_the_older_transform_holds() -> None:
    buffer = buffer_of(
        transform("a", "x", seconds(1), (1.0, 0.0, 0.0)),
        transform("b", "x", seconds(3), (9.0, 0.0, 0.0)),
    )

    assert buffer.lookup_transform("a", "x", seconds(2)).transform.translation.x == 1.0


ONE = transform("map", "base", seconds(2))
TWO = transform("map", "base", seconds(4))
WHERE = ", when looking up transform from frame [base] to frame [map]"
NOT_CONNECTED = (
    "Could not find a connection between 'map' and 'y' because they are not part of the same tree."
    "Tf has two or more unconnected trees."
)


@pytest.mark.parametrize(
    ("known", "target", "source", "at", "error", "text"),
    [
        (
            (ONE,), "nope", "base", 0, LookupException,
            '"nope" passed to lookupTransform argument target_frame does not exist. ',
        ),
        (
            (ONE,), "map", "nope", 0, LookupException,
            '"nope" passed to lookupTransform argument source_frame does not exist. ',
        ),
        (
            (ONE,), "/map", "base", 0, InvalidArgumentException,
            'Invalid argument "/map" passed to lookupTransform argument target_frame - in tf2 frame_ids cannot start '
            "with a '/'",
        ),
        (
            (ONE,), "map", "", 0, InvalidArgumentException,
            'Invalid argument "" passed to lookupTransform argument source_frame - in tf2 frame_ids cannot be empty',
        ),
        ((ONE, transform("x", "y", seconds(2))), "map", "y", 0, ConnectivityException, NOT_CONNECTED),
        ((ONE, transform("x", "y", seconds(2))), "map", "y", 2, ConnectivityException, NOT_CONNECTED),
        (
            (ONE,), "map", "base", 3, ExtrapolationException,
            "Lookup would require extrapolation at time 3.000000, but only time 2.000000 is in the buffer" + WHERE,
        ),
        (
            (ONE, TWO), "map", "base", 5, ExtrapolationException,
            "Lookup would require extrapolation into the future.  Requested time 5.000000 but the latest data is at "
            "time 4.000000" + WHERE,
        ),
        (
            (ONE, TWO), "map", "base", 1, ExtrapolationException,
            "Lookup would require extrapolation into the past.  Requested time 1.000000 but the earliest data is at "
            "time 2.000000" + WHERE,
        ),
    ],
)  # fmt: skip
def test_a_failed_lookup_has_the_error_and_the_text_of_tf2(
    known: tuple[TransformStamped, ...], target: str, source: str, at: float, error: type[Exception], text: str
) -> None:
    buffer = buffer_of(*known)

    with pytest.raises(error) as caught:
        buffer.lookup_transform(target, source, seconds(at))

    assert str(caught.value) == text
    assert not buffer.can_transform(target, source, seconds(at))


@pytest.mark.parametrize(
    ("wrong", "problem"),
    [
        (transform("base", "base", seconds(1)), "the same frame at both ends"),
        (transform("", "base", seconds(1)), "lacks the name"),
        (transform("map", "base", seconds(1), (math.nan, 0.0, 0.0)), "not finite"),
        (transform("map", "base", seconds(1), (math.inf, 0.0, 0.0)), "not finite"),
        (transform("map", "base", seconds(1), q=(0, 0, 0, 1.1)), "not of length 1"),
        (transform("laser", "map", seconds(1)), "its own ancestor"),
    ],
)
def test_a_wrong_transform_is_refused_and_changes_nothing(wrong: TransformStamped, problem: str) -> None:
    buffer = buffer_of(transform("map", "base", seconds(1)), transform("base", "laser", seconds(1)))

    with pytest.raises(InvalidArgumentException, match=problem):
        buffer.set_transform(wrong, "robot1")

    assert buffer.lookup_transform("map", "laser").transform.translation.x == 2.0


def test_a_frame_too_far_below_the_root_is_refused() -> None:
    """Each transform of a chain costs time for all that are above it: 900 in a row blocked the loop for seconds."""
    buffer = TransformBuffer()
    for depth in range(MAX_DEPTH - 1):
        buffer.set_transform(transform(f"f{depth}", f"f{depth + 1}", seconds(1)))

    with pytest.raises(InvalidArgumentException, match="below the root"):
        buffer.set_transform(transform(f"f{MAX_DEPTH - 1}", f"f{MAX_DEPTH}", seconds(1)))
    assert buffer.lookup_transform("f0", f"f{MAX_DEPTH - 1}").transform.translation.x == MAX_DEPTH - 1

    buffer.set_transform(transform("above", "f0", seconds(1)))
    buffer.set_transform(transform("root", "above", seconds(1)))
    with pytest.raises(LookupException, match="deeper"):
        buffer.lookup_transform("root", f"f{MAX_DEPTH - 1}")


def test_transforms_are_kept_for_ten_seconds_and_older_ones_refused() -> None:
    buffer = buffer_of(transform("map", "base", seconds(1)), transform("map", "base", seconds(12)))

    assert not buffer.set_transform(transform("map", "base", seconds(1.5)))
    assert buffer.set_transform(transform("map", "base", seconds(11), (5.0, 0.0, 0.0)))
    assert buffer.lookup_transform("map", "base", seconds(11)).transform.translation.x == 5.0
    assert not buffer.can_transform("map", "base", seconds(1))


@pytest.mark.parametrize("asked", [None, 2, 3])
def test_of_transforms_with_one_stamp_the_last_inserted_holds(asked: float | None) -> None:
    """As in ``cache_unittest.cpp``, ``GetAllItems``: two nodes publish the frame, or one corrects it."""
    stamped = [(1, 0.0), (2, 1.0), (3, 1.0), (2, 2.0), (3, 2.0)]
    buffer = buffer_of(*(transform("map", "base", seconds(at), (x, 0.0, 0.0)) for at, x in stamped))

    at = None if asked is None else seconds(asked)
    assert buffer.lookup_transform("map", "base", at).transform.translation.x == 2.0


def test_a_static_transform_holds_at_any_time_survives_a_clear_and_is_replaced_by_a_dynamic_one() -> None:
    buffer = TransformBuffer()
    buffer.set_transform_static(transform("map", "dock", seconds(0)))

    buffer.clear()
    assert buffer.can_transform("map", "dock", seconds(1_000))

    buffer.set_transform(transform("map", "dock", seconds(3)))
    assert not buffer.can_transform("map", "dock", seconds(1_000))


def test_a_slash_before_a_frame_is_dropped_when_it_is_set() -> None:
    buffer = buffer_of(transform("/map", "/base", seconds(1)))

    assert buffer.can_transform("map", "base")
