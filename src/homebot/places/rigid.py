"""Rotations and rigid transforms in space. Pure.

A quaternion is ``x, y, z, w`` and has the norm 1, as in ROS (REP 103).
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

__all__ = ["IDENTITY", "Rigid", "yaw_of"]

Vector: TypeAlias = tuple[float, float, float]
Quaternion: TypeAlias = tuple[float, float, float, float]

_NEARLY_PARALLEL = 0.9995


class Rigid(NamedTuple):
    """A transform: it maps points of a child frame into its parent frame.

    Attributes:
        translation: The origin of the child frame, in metres.
        rotation: The orientation of the child frame.
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
        qx, qy, qz, qw = (one / norm for one in turned)
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
