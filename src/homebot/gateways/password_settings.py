"""The keys by which a table of the configuration names a password."""

import os
from pathlib import Path
from typing import Self

from pydantic import BaseModel, ConfigDict, SecretStr, model_validator

from homebot.config import FilePath
from homebot.errors import UsageError
from homebot.support.file_access import check_secret_file, read_secret

__all__ = ["PasswordSettings", "check_secret_file", "read_password"]


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


def read_password(password_file: Path | None, password_env: str | None, name: str = "password") -> SecretStr | None:
    """Return the password, or other secret, that a table names by one of these keys; None where it names none.

    Args:
        password_file: File with the password in its first line.
        password_env: Environment variable that holds the password.
        name: Prefix of the keys.

    Raises:
        UsageError: It cannot be read; names the key.
    """
    if password_env is not None:
        if password_env not in os.environ:
            raise UsageError(f"{name}_env: the environment variable {password_env} is not set")
        return SecretStr(os.environ[password_env])
    if password_file is not None:
        try:
            return SecretStr(read_secret(password_file))
        except UsageError as exc:
            raise UsageError(f"{name}_file: {exc}") from exc
    return None
