"""Backup and restore of a house that runs, and of one that does not; archives of strangers are refused."""

import hashlib
import io
import json
import os
import sqlite3
import tarfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.cli.conftest import Homebot

from homebot.apps.stores import StoreFile
from homebot.cli import main
from homebot.cli.commands.backup import copies_in
from homebot.devices.names import COPY_FILES
from homebot.discovery.record import Records
from homebot.discovery.store import IndexFile, index_path
from homebot.errors import LinkError
from homebot.features.history.history_file import HistoryFile
from homebot.features.history.settings import KeepSettings
from homebot.graph import Graph, Node
from homebot.journal.journal_file import JournalFile
from homebot.runtime.saved_files import serve_copies
from homebot.support.owner_token import OWNER_FILE, make_owner_token
from homebot.support.sqlite_file import SqliteFile

Text = pytest.CaptureFixture[str]

CONFIG = """
[home]
name = "villa"
[gateways.mqtt]
url = "mqtt://10.0.0.1"
user = "robot"
password_file = "password"
[apps.mine]
class = "mine.py:Mine"
"""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path / "data"))
    Path("homebot.toml").write_text(CONFIG)
    Path("mine.py").write_text("from homebot import App\nclass Mine(App):\n    async def run(self): ...\n")
    Path("password").touch(mode=0o600)
    Path("password").write_text("hunter2")


@pytest.fixture
def data() -> Path:
    return index_path("villa", "10.0.0.1:1883").parent


@pytest.fixture
def files(data: Path) -> Iterator[dict[str, SqliteFile]]:
    """All files of a house, open."""
    found: dict[str, SqliteFile] = {
        "index.sqlite": IndexFile(data / "index.sqlite"),
        "journal.sqlite": JournalFile(data / "journal.sqlite"),
        "history.sqlite": HistoryFile(data / "history.sqlite", KeepSettings()),
        "apps.sqlite": StoreFile(data / "apps.sqlite"),
    }
    for one in found.values():
        one.open(0.0)
    index, store = found["index.sqlite"], found["apps.sqlite"]
    assert isinstance(index, IndexFile)
    assert isinstance(store, StoreFile)
    index.write(Records((("lamp", "{}"),), ()), ["lamp"])
    store.write({("mine", "count"): "7"})
    yield found
    for one in found.values():
        one.close()


def close(files: dict[str, SqliteFile]) -> None:
    for one in files.values():
        one.close()


def members(archive: str) -> dict[str, bytes]:
    with tarfile.open(archive) as tar:
        return {one.name: tar.extractfile(one).read() for one in tar}  # type: ignore[union-attr]


def rows(file: Path, query: str) -> list[Any]:
    connection = sqlite3.connect(file)
    try:
        return connection.execute(query).fetchall()
    finally:
        connection.close()


def test_a_stopped_house_goes_and_comes_back(data: Path, files: dict[str, SqliteFile], capsys: Text) -> None:
    close(files)
    Path("homebot.toml").chmod(mode := 0o644)
    assert main(["backup", "villa.tar"]) == 0
    assert "left out, because they contain secrets: password; --with-tokens includes them" in capsys.readouterr().out
    assert Path("villa.tar").stat().st_mode & 0o777 == 0o600
    found = members("villa.tar")
    assert set(found) == {"manifest.json", "config/homebot.toml", "config/mine.py", *(f"data/{one}" for one in files)}
    manifest = json.loads(found["manifest.json"])
    assert manifest["files"]["data/index.sqlite"]["version"] == 3
    assert not list(data.glob("copies-*"))

    Path("homebot.toml").write_text("# lost")
    rows_before = rows(data / "apps.sqlite", "SELECT * FROM store")
    Path("password").unlink()
    assert main(["restore", "villa.tar"]) == 0
    out = capsys.readouterr().out
    assert "missing, because they contain secrets: password; put them there" in out
    assert out.startswith("restored villa, as it was on ")
    assert out.count("moved aside: ") == 2
    assert Path("homebot.toml").read_text() == CONFIG
    assert Path("homebot.toml").stat().st_mode & 0o777 == mode
    assert rows(data / "apps.sqlite", "SELECT * FROM store") == rows_before == [("mine", "count", "7")]
    assert rows(data / "index.sqlite", "SELECT id FROM devices") == [("lamp",)]
    assert data.stat().st_mode & 0o077 == 0
    assert sorted(one.name for one in data.parent.parent.iterdir()) == ["villa"]  # nothing is left of it
    assert main(["restore", "villa.tar"]) == 0  # in the same second


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root gives files away")
def test_what_root_restores_belongs_to_the_user_of_the_data(data: Path, files: dict[str, SqliteFile]) -> None:
    close(files)
    assert main(["backup", "villa.tar"]) == 0
    os.chown("data", 1000, 1000)
    assert main(["restore", "villa.tar"]) == 0
    assert {one.stat().st_uid for one in (data.parent, data, *data.iterdir())} == {1000}


def test_secrets_go_along_only_when_asked_for(files: dict[str, SqliteFile], capsys: Text) -> None:
    close(files)
    Path("homebot.toml").write_text(CONFIG + '[door]\ntoken = "geheim"\n')
    assert main(["backup", "one.tar"]) == 0
    assert "left out, because they contain secrets: homebot.toml, password" in capsys.readouterr().out
    raw = Path("one.tar").read_bytes()
    assert b"geheim" not in raw
    assert b"hunter2" not in raw
    assert main(["backup", "two.tar", "--with-tokens"]) == 0
    assert members("two.tar")["config/password"] == b"hunter2"


def test_the_owners_token_never_goes_along(files: dict[str, SqliteFile], monkeypatch: pytest.MonkeyPatch) -> None:
    """Not even where the data is beside the configuration, as in a container."""
    close(files)
    monkeypatch.setenv("HOMEBOT_DATA", ".")
    for folder in (Path(), Path("data")):
        token = make_owner_token(folder / OWNER_FILE).secret
        monkeypatch.setenv("HOMEBOT_DATA", str(folder))
        assert main(["backup", str(folder / "own.tar"), "--with-tokens"]) == 0
        assert token.encode() not in (folder / "own.tar").read_bytes()


def test_a_file_that_is_there_is_not_overwritten(files: dict[str, SqliteFile], capsys: Text) -> None:
    close(files)
    Path("villa.tar").write_text("mine")
    assert main(["backup", "villa.tar"]) == 1
    assert "villa.tar exists already; delete it, or choose another name" in capsys.readouterr().err
    assert Path("villa.tar").read_text() == "mine"


def test_a_running_house_makes_the_copies_itself_and_refuses_a_restore(
    data: Path, files: dict[str, SqliteFile], homebot_with: Callable[..., Homebot], capsys: Text
) -> None:
    def node(graph: Graph) -> Node:
        one = Node(graph, "homebot")
        serve_copies(one, data)
        return one

    homebot = homebot_with(node, None)
    assert main(["backup", "villa.tar", "--door", homebot.door]) == 0
    Path("copy.sqlite").write_bytes(members("villa.tar")["data/apps.sqlite"])
    assert rows(Path("copy.sqlite"), "SELECT value FROM store") == [("7",)]
    assert not list(data.glob("copies-*"))
    capsys.readouterr()
    assert main(["restore", "villa.tar"]) == 1
    assert "is in use by a running homebot; stop it first" in capsys.readouterr().err
    assert rows_of_open(files) == [("7",)]


def rows_of_open(files: dict[str, SqliteFile]) -> list[Any]:
    store = files["apps.sqlite"]
    assert isinstance(store, StoreFile)
    return [(one["count"],) for one in store.read().values()]


def test_a_copy_waits_for_a_transaction_of_another_thread(files: dict[str, SqliteFile], tmp_path: Path) -> None:
    store = files["apps.sqlite"]
    connection = store._connection
    assert connection is not None
    connection.execute("INSERT INTO store VALUES ('mine', 'half', '1')")  # begins a transaction
    timer = threading.Timer(0.2, connection.rollback)
    timer.start()
    store.copy_into(tmp_path / "copy")
    timer.join()
    assert rows(tmp_path / "copy", "SELECT key FROM store") == [("count",)]


def test_homes_that_keep_nothing_say_so(homebot_with: Callable[..., Homebot], capsys: Text) -> None:
    def node(graph: Graph) -> Node:
        one = Node(graph, "homebot")
        serve_copies(one, None)
        return one

    homebot = homebot_with(node, None)
    assert main(["--door", homebot.door, "service", "call", COPY_FILES]) == 1
    assert "this homebot keeps nothing" in "".join(capsys.readouterr())


def archive(changes: Callable[[dict[str, Any]], None] = lambda _: None, *more: tarfile.TarInfo) -> str:
    """Write an archive of one file whose manifest is changed."""
    content = b"[home]\n"
    file = {"size": len(content), "sha256": hashlib.sha256(content).hexdigest(), "version": None}
    manifest = {"format": 1, "version": "0.1.0", "made": "now", "home": "h", "folder": "a/b"}
    manifest = {**manifest, "files": {"config/homebot.toml": file}}
    changes(manifest)
    with tarfile.open("bad.tar", "w") as tar:
        texts = {"manifest.json": json.dumps(manifest).encode(), "config/homebot.toml": content}
        for name, text in texts.items():
            member = tarfile.TarInfo(name)
            member.size = len(text)
            tar.addfile(member, io.BytesIO(text))
        for one in more:
            tar.addfile(one)
    return "bad.tar"


def _with(name: str, kind: bytes = tarfile.REGTYPE, link: str = "") -> tarfile.TarInfo:
    member = tarfile.TarInfo(name)
    member.type, member.linkname = kind, link
    return member


def _named(name: str) -> Callable[[dict[str, Any]], None]:
    return lambda manifest: manifest["files"].update({name: {"size": 0, "sha256": "0" * 64, "version": None}})


def _toml(key: str, value: object) -> Callable[[dict[str, Any]], None]:
    return lambda manifest: manifest["files"]["config/homebot.toml"].update({key: value})


@pytest.mark.parametrize(
    ("changes", "more", "problem"),
    [
        (_named("../outside"), (), "manifest.json: files.../outside"),
        (_named("config/../../outside"), (), "is outside the backup"),
        (_named("config//etc/passwd"), (), "is outside the backup"),
        (_named("config/.bashrc"), (), "is outside the backup"),
        (_named("config/\x1b[2Jmine.py"), (), r"files.config/\x1b[2Jmine.py"),
        (_named("config/mine\n.py"), (), r"files.config/mine\n.py"),
        (
            lambda one: one.update(home="h\nrestored"),
            (),
            "manifest.json: home: Value error, 'h\\nrestored' has control",
        ),
        (lambda one: one.update(folder="../.."), (), "manifest.json: folder"),
        (lambda one: one.update(format=2), (), "manifest.json: format"),
        (_toml("size", 10**15), (), "is too large: there is only room for"),
        (_toml("size", 3), (), "config/homebot.toml has 7 bytes, not 3"),
        (_toml("sha256", "0" * 64), (), "config/homebot.toml has another checksum"),
        (_named("config/other"), (), "lacks config/other; is it complete?"),
        (lambda _: None, (_with("config/more"),), "'config/more' does not belong in a backup"),
        (_named("config/x"), (_with("config/x", tarfile.SYMTYPE, "/etc/passwd"),), "'config/x' does not belong"),
        (_named("config/x"), (_with("config/x", tarfile.LNKTYPE, "/etc/passwd"),), "'config/x' does not belong"),
        (lambda _: None, (_with("config/homebot.toml"),), "'config/homebot.toml' does not belong in a backup"),
    ],
)
def test_an_archive_that_is_not_as_it_should_be_changes_nothing(
    capsys: Text, changes: Callable[[dict[str, Any]], None], more: tuple[tarfile.TarInfo, ...], problem: str
) -> None:
    assert main(["restore", archive(changes, *more)]) == 1
    assert problem in capsys.readouterr().err
    assert Path("homebot.toml").read_text() == CONFIG
    assert os.listdir("data") == []  # noqa: PTH208 - names alone


@pytest.mark.parametrize("content", [b"", b"no tar at all" * 100])
def test_what_is_no_archive_is_told(capsys: Text, content: bytes) -> None:
    Path("bad.tar").write_bytes(content)
    assert main(["restore", "bad.tar"]) == 1
    assert "bad.tar is not a backup of homebot" in capsys.readouterr().err


def test_an_archive_that_was_cut_changes_nothing(files: dict[str, SqliteFile], capsys: Text) -> None:
    close(files)
    assert main(["backup", "villa.tar"]) == 0
    Path("villa.tar").write_bytes(Path("villa.tar").read_bytes()[:30_000])
    Path("homebot.toml").write_text("# mine")
    assert main(["restore", "villa.tar"]) == 1
    assert "villa.tar" in capsys.readouterr().err
    assert Path("homebot.toml").read_text() == "# mine"


def test_files_of_a_newer_homebot_are_refused(data: Path, files: dict[str, SqliteFile], capsys: Text) -> None:
    close(files)
    connection = sqlite3.connect(data / "journal.sqlite")
    connection.execute("PRAGMA user_version = 99")
    connection.close()
    assert main(["backup", "villa.tar"]) == 0
    assert main(["restore", "villa.tar"]) == 1
    assert "journal.sqlite was written by a newer homebot (version 99" in capsys.readouterr().err


@pytest.mark.parametrize("answer", ["{0}/..", "{0}/copies/..", "{0}", "{0}/../other/copies", "/", ""])
def test_a_folder_that_is_none_of_copies_is_not_removed(tmp_path: Path, answer: str) -> None:
    """The answer of a program that says it is homebot; what it names is removed once it was read."""
    folder = tmp_path / "villa"
    folder.mkdir()
    with pytest.raises(LinkError, match="run this where it runs"):
        copies_in(folder, answer.format(folder))
    assert copies_in(folder, f"{folder}/copies") == folder / "copies"
