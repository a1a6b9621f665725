"""Rotations and rigid transforms in space and in the plane. Pure.

A quaternion is ``x, y, z, w`` and has the norm 1, as in ROS (REP 103).
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]

_NEARLY_PARALLEL = 0.9995
_MIN_POINTS = 3
_MISFIT = 1.0
"""The largest distance of a point from its counterpart, in metres."""


class MapPose(NamedTuple):
    """A position on a map, or of one map in another.

    Attributes:
        x: Metres.
        y: Metres.
        yaw: Radians from the x axis, counter-clockwise.
    """

    x: float
    y: float
    yaw: float = 0.0

    def then(self, inner: MapPose) -> MapPose:
        """Return *inner*, which is relative to this pose, in the frame of this pose."""
        at = complex(self.x, self.y) + cmath.rect(1.0, self.yaw) * complex(inner.x, inner.y)
        return MapPose(at.real, at.imag, math.remainder(self.yaw + inner.yaw, math.tau))


def fitted_pose(pairs: Sequence[tuple[complex, complex]]) -> MapPose | None:
    """Return the pose of a map in another, fitted to its points x + iy and their counterparts there.

    None for fewer than three points, or if one ends up a metre away.
    """
    if len(pairs) < _MIN_POINTS:
        return None
    own, other = (sum(pair[side] for pair in pairs) / len(pairs) for side in (0, 1))
    turn = sum((there - other) * (here - own).conjugate() for here, there in pairs)
    if not turn:
        return None
    turn /= abs(turn)
    shift = other - turn * own
    if max(abs(shift + turn * here - there) for here, there in pairs) > _MISFIT:
        return None
    return MapPose(shift.real, shift.imag, cmath.phase(turn))


class Rigid(NamedTuple):
    """A transform: it maps points of a child frame into its parent frame.

    Attributes:
        translation: The origin of the child frame, in metres.
    """

    translation: Vector
    rotation: Quaternion

    def then(self, inner: Rigid) -> Rigid:
        """Return the transform that applies *inner* first."""
        (x, y, z), (moved_x, moved_y, moved_z) = self.translation, _rotate(self.rotation, inner.translation)
        ax, ay, az, aw = self.rotation
        bx, by, bz, bw = inner.rotation
        rotation = (
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        )
        return Rigid((x + moved_x, y + moved_y, z + moved_z), rotation)

    def inverse(self) -> Rigid:
        """Return the transform from the parent frame into the child frame."""
        x, y, z, w = self.rotation
        back = (-x, -y, -z, w)
        moved_x, moved_y, moved_z = _rotate(back, self.translation)
        return Rigid((-moved_x, -moved_y, -moved_z), back)

    def between(self, later: Rigid, share: float) -> Rigid:
        """Return the transform at *share*, 0 to 1, of the shorter way to *later*."""
        x, y, z = (a + (b - a) * share for a, b in zip(self.translation, later.translation, strict=True))
        cosine = sum(map(float.__mul__, self.rotation, later.rotation))
        sign, angle = math.copysign(1.0, cosine), math.acos(min(1.0, abs(cosine)))
        first, last = 1.0 - share, share
        if abs(cosine) < _NEARLY_PARALLEL:
            first, last = math.sin(first * angle), math.sin(last * angle)
        turned = [a * first + b * last * sign for a, b in zip(self.rotation, later.rotation, strict=True)]
        norm = math.hypot(*turned)
        qx, qy, qz, qw = (component / norm for component in turned)
        return Rigid((x, y, z), (qx, qy, qz, qw))


IDENTITY = Rigid((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def yaw_of(rotation: Quaternion) -> float:
    """Return the rotation about the z axis, in radians from the x axis, counter-clockwise."""
    x, y, z, w = rotation
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _rotate(rotation: Quaternion, vector: Vector) -> Vector:
    x, y, z, w = rotation
    vx, vy, vz = vector
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx
