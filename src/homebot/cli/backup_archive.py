"""The archive of a backup: a tar that begins with its manifest. It is validated, since it may be from a stranger."""

import hashlib
import io
import os
import shutil
import tarfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import IO, Annotated, Final, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from homebot.errors import UsageError
from homebot.support.new_file import create_file
from homebot.support.printable import printable

_MANIFEST: Final = "manifest.json"
_MAX_MANIFEST: Final = 1_000_000
_MAX_BYTES: Final = 16 * 2**30
_BLOCK: Final = 1_048_576


def _check_line(text: str) -> str:
    if not text.isprintable():
        raise ValueError(f"{text[:100]!r} has control characters")
    return text


_Line = Annotated[str, Field(max_length=500), AfterValidator(_check_line)]
_Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
_Name = Annotated[_Line, Field(pattern=r"^(data/[\w.-]+|config/.+)$")]


class ArchivedFile(BaseModel):
    """A file of an archive."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    size: Annotated[int, Field(ge=0)]
    sha256: _Digest
    version: int | None = None
    mode: Annotated[int, Field(ge=0, le=0o777)] = 0o600


class Manifest(BaseModel):
    """The first member of an archive.

    Attributes:
        version: The version of the homebot that wrote it.
        made: The time of the backup, in ISO 8601.
        folder: The data folder, relative to that of all homes.
        files: The files by name in the archive: ``data/…`` and ``config/…``.
        left_out: Names of missing files that contain secrets, next to ``homebot.toml``.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    format: Literal[1] = 1
    version: _Line
    made: _Line
    home: _Line
    folder: Annotated[str, Field(pattern=r"^\w+/\w+$")]
    files: Annotated[dict[_Name, ArchivedFile], Field(max_length=1000)]
    left_out: tuple[_Line, ...] = ()


def write_archive(target: Path, manifest: Manifest, files: Mapping[str, Path]) -> None:
    """Write *files*, by name in the archive, to the new file *target*, which only the user can read.

    Raises:
        UsageError: It exists already, or cannot be written.
    """
    sums = {name: file.model_copy(update=_facts_of(files[name])) for name, file in manifest.files.items()}
    text = manifest.model_copy(update={"files": sums}).model_dump_json(indent=2).encode()
    created = create_file(target)
    try:
        with created as file, tarfile.open(fileobj=file, mode="w") as tar:
            _add(tar, _MANIFEST, len(text), io.BytesIO(text))
            for name, path in files.items():
                with path.open("rb") as content:
                    _add(tar, name, sums[name].size, content)
    except BaseException as exc:
        target.unlink()
        if isinstance(exc, OSError):
            raise UsageError(f"{target} cannot be written: {exc.strerror or exc}") from exc
        raise


def extract_archive(source: Path, into: Path) -> Manifest:
    """Extract the archive *source* into the folder *into*, checking each member; return its manifest.

    Raises:
        UsageError: It is not a backup, or has a member that does not belong there, is too large or is damaged.
    """
    with _readable(source) as tar:
        manifest = _read_manifest(source, tar)
        missing = set(manifest.files)
        room = min(_MAX_BYTES, shutil.disk_usage(into).free)
        if sum(file.size for file in manifest.files.values()) > room:
            raise UsageError(f"{source} is too large: there is only room for {room // 2**20:,} MB in {into.parent}")
        for member in iter(tar.next, None):
            file = manifest.files.get(member.name)
            if file is None or member.name not in missing or not member.isreg() or member.issparse():
                raise UsageError(f"{source}: {member.name[:200]!r} does not belong in a backup; nothing was restored")
            if member.size != file.size:
                raise UsageError(f"{source}: {member.name} has {member.size} bytes, not {file.size}")
            missing.discard(member.name)
            _extract(source, tar, member, into, file.sha256)
        if missing:
            raise UsageError(f"{source} lacks {', '.join(sorted(missing))}; is it complete?")
        return manifest


@contextmanager
def _readable(source: Path) -> Iterator[tarfile.TarFile]:
    try:
        with tarfile.open(source, "r:") as tar:
            yield tar
    except tarfile.TarError as exc:
        raise UsageError(f"{source} is not a backup of homebot, or is incomplete: {exc}") from exc
    except OSError as exc:
        raise UsageError(f"{source}: {exc.strerror or exc}") from exc


def _read_manifest(source: Path, tar: tarfile.TarFile) -> Manifest:
    member = tar.next()
    if member is None or member.name != _MANIFEST or not member.isreg() or member.size > _MAX_MANIFEST:
        raise UsageError(f"{source} is not a backup of homebot: it does not begin with {_MANIFEST}")
    content = tar.extractfile(member)
    try:
        manifest = Manifest.model_validate_json(content.read() if content else b"")
    except ValidationError as exc:
        where = printable(".".join(map(str, exc.errors()[0]["loc"])))
        raise UsageError(f"{source}: {_MANIFEST}: {where}: {exc.errors()[0]['msg']}") from None
    for name in manifest.files:
        is_hidden = any(part.startswith(".") for part in PurePosixPath(name).parts)
        if is_hidden or "\\" in name or "//" in name or "\0" in name:
            raise UsageError(f"{source}: {name[:200]!r} is outside the backup; nothing was restored")
    return manifest


def _extract(source: Path, tar: tarfile.TarFile, member: tarfile.TarInfo, into: Path, expected: str) -> None:
    target, digest = into / member.name, hashlib.sha256()
    target.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    content = tar.extractfile(member)
    assert content is not None  # noqa: S101 - it is a regular file
    with create_file(target) as file:
        while block := content.read(_BLOCK):
            digest.update(block)
            file.write(block)
    if digest.hexdigest() != expected:
        raise UsageError(f"{source}: {member.name} has another checksum: the file is damaged; nothing was restored")


def _add(tar: tarfile.TarFile, name: str, size: int, content: IO[bytes]) -> None:
    member = tarfile.TarInfo(name)
    member.size, member.mode = size, 0o600
    tar.addfile(member, content)


def _facts_of(path: Path) -> dict[str, object]:
    with path.open("rb") as file:
        status = os.fstat(file.fileno())
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return {"size": status.st_size, "sha256": digest, "mode": status.st_mode & 0o777}
