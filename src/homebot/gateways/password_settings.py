"""The keys by which a table of the configuration names a password."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ConfigDict, SecretStr, model_validator

from homebot.config import FilePath, read_password

__all__ = ["PasswordSettings"]


class PasswordSettings(BaseModel):
    """A table, or a part of one, that may name a password.

    Attributes:
        password_file: File with the password in its first line, readable by its owner only. Relative paths begin at the
            folder of the configuration's file.
        password_env: Environment variable that holds the password.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    password_file: FilePath | None = None
    password_env: str | None = None

    @model_validator(mode="after")
    def _check_one_source(self) -> Self:
        if self.password_file and self.password_env:
            raise ValueError("give password_file or password_env, not both")
        return self

    def read_password(self, table: str = "") -> SecretStr | None:
        """Return the password; None where none is named.

        Args:
            table: Prefix of its keys in errors: ``devices.hall.``

        Raises:
            UsageError: It cannot be read; names the key.
        """
        return read_password(self.password_file, self.password_env, f"{table}password")
