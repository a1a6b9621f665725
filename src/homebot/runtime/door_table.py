"""The table ``[door]`` of the configuration: the door's settings, whose token may also lie in a file."""

from __future__ import annotations

from pydantic import SecretStr, model_validator

from homebot.bridges.rosbridge import DoorSettings
from homebot.config import FilePath, read_secret

__all__ = ["DoorTable"]


class DoorTable(DoorSettings):
    """The keys of the table ``[door]``.

    Attributes:
        token_file: File whose first line is the token, for nobody else to read.
    """

    token_file: FilePath | None = None

    @model_validator(mode="after")
    def _check_token(self) -> DoorTable:
        if self.token is not None and self.token_file is not None:
            raise ValueError("give token or token_file, not both")
        return self

    def settings(self) -> DoorSettings:
        """Return the door's settings, with the token read from where it is kept.

        Raises:
            UsageError: The file cannot be read, or its first line is empty.
        """
        values = {name: value for name, value in self if name != "token_file"}
        if self.token_file is not None:
            values["token"] = SecretStr(read_secret(self.token_file))
        return DoorSettings(**values)
