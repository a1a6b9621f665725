"""Record of something that was learnt: the JSON in which it is kept over a restart. Pure."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar, Literal, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, ValidationError

from homebot.errors import WireError

__all__ = ["KeepLearnt", "LearntRecord"]

KeepLearnt: TypeAlias = Callable[[str, str, str], None]
"""Keeps what was learnt over a restart: its name, the record, empty where it is forgotten, and the command's id."""


class LearntRecord(BaseModel):
    """Fields of something that was learnt, as it is kept; those that a later version adds are ignored.

    Attributes:
        title: What it is called in errors.
        version: Of this kind of record; another one is refused.
    """

    model_config = ConfigDict(extra="ignore", defer_build=True)

    title: ClassVar[str]

    version: Literal[1] = 1

    @property
    @abstractmethod
    def kept_as(self) -> str:
        """The name under which it is kept, one of its kind."""

    @classmethod
    def read(cls, name: str, text: str) -> Self:
        """Return the record that is kept as *text* under *name*.

        Raises:
            WireError: It is no such record, of another version, or kept under another name.
        """
        try:
            record = cls.model_validate_json(text)
        except ValidationError as exc:
            raise WireError(f"it is no {cls.title}: {exc.errors()[0]['msg']}", text.encode()) from exc
        if name != record.kept_as:
            raise WireError("its name is that of another", text.encode())
        return record
