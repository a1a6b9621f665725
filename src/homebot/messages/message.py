"""The base of every message on the graph."""

from __future__ import annotations

from typing import ClassVar

from pydantic import BaseModel, ConfigDict

__all__ = ["Message"]


class Message(BaseModel):
    """A frozen value with exact ROS field types, checked once where it is made and then passed by reference.

    Attributes:
        ros_type: The full ROS name of the type, ``package/msg/Name``; by default ``<top-level package>/msg/<class>``.
        key_field: Name of the field that tells one instance on a topic from another (a DDS key); a topic of a type
            that has one keeps its history per key.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=True)

    ros_type: ClassVar[str]
    key_field: ClassVar[str | None] = None

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "ros_type" not in cls.__dict__:
            cls.ros_type = f"{cls.__module__.partition('.')[0]}/msg/{cls.__name__}"
