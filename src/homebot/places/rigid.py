"""Rotations and rigid transforms in space. Pure.

A quaternion is ``x, y, z, w`` and has the norm 1, as in ROS (REP 103).
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

__all__ = ["IDENTITY", "Quaternion", "Rigid", "Vector", "rotate", "slerp", "yaw_of"]

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
        x, y, z = rotate(self.rotation, inner.translation)
        own = self.translation
        return Rigid((own[0] + x, own[1] + y, own[2] + z), _product(self.rotation, inner.rotation))

    def inverse(self) -> Rigid:
        """Return the transform from the parent frame into the child frame."""
        x, y, z, w = self.rotation
        back = (-x, -y, -z, w)
        moved = rotate(back, self.translation)
        return Rigid((-moved[0], -moved[1], -moved[2]), back)

    def between(self, later: Rigid, share: float) -> Rigid:
        """Return the transform at *share*, 0 to 1, of the way to *later*."""
        first, last = self.translation, later.translation
        moved = (
            first[0] + (last[0] - first[0]) * share,
            first[1] + (last[1] - first[1]) * share,
            first[2] + (last[2] - first[2]) * share,
        )
        return Rigid(moved, slerp(self.rotation, later.rotation, share))


IDENTITY = Rigid((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def rotate(rotation: Quaternion, vector: Vector) -> Vector:
    """Return *vector*, rotated."""
    x, y, z, w = rotation
    vx, vy, vz = vector
    tx, ty, tz = 2 * (y * vz - z * vy), 2 * (z * vx - x * vz), 2 * (x * vy - y * vx)
    return vx + w * tx + y * tz - z * ty, vy + w * ty + z * tx - x * tz, vz + w * tz + x * ty - y * tx


def slerp(first: Quaternion, last: Quaternion, share: float) -> Quaternion:
    """Return the rotation at *share* of the shorter way from *first* to *last*."""
    cosine = sum(map(float.__mul__, first, last))
    sign = -1.0 if cosine < 0 else 1.0
    cosine *= sign
    if cosine > _NEARLY_PARALLEL:
        weights = 1.0 - share, share * sign
    else:
        angle = math.acos(cosine)
        weights = math.sin((1.0 - share) * angle) / math.sin(angle), math.sin(share * angle) / math.sin(angle) * sign
    x, y, z, w = (a * weights[0] + b * weights[1] for a, b in zip(first, last, strict=True))
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    return x / norm, y / norm, z / norm, w / norm


def yaw_of(rotation: Quaternion) -> float:
    """Return the rotation about the z axis, in radians from the x axis, counter-clockwise."""
    x, y, z, w = rotation
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
