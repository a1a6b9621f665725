"""The data of a home stay its own when its configuration changes, and when that of an earlier version is taken over."""

from pathlib import Path

import pytest

from homebot.config import load_config
from homebot.discovery.record import Records
from homebot.discovery.store import IndexFile, index_path
from homebot.errors import ConfigError, UsageError
from homebot.runtime.home_folder import adopt_folder, index_place, settle_home, unused_folders

BROKER, TLS, HOST, HUE = (
    '[gateways.mqtt]\nurl = "mqtt://10.0.0.1"\n',
    '[gateways.mqtt]\nurl = "mqtts://10.0.0.1"\n',
    '[gateways.mqtt]\nurl = "mqtt://broker.lan"\n',
    '[gateways.memory]\nclass = "homebot.gateways.memory:MemoryGateway"\n',
)
VILLA, CAPITAL = '[home]  # of us\nname = "villa"\n', '[home]\nname = "Villa"\n'


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path / "data"))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "homebot.toml"


def keep(index: Path, device: str) -> Path:
    """Store *device* in the file *index*; return its folder."""
    stored = IndexFile(index)
    stored.open(0.0)
    stored.write(Records(((device, "{}"),), ()), [device])
    stored.close()
    return index.parent


def devices(index: Path) -> list[str]:
    stored = IndexFile(index)
    stored.open(0.0)
    try:
        return [device for device, _ in stored.read().devices]
    finally:
        stored.close()


def start(file: Path) -> Path:
    return settle_home(load_config(file), file)


def moved(file: Path, text: str) -> None:
    """Write a configuration *text*, with the id that *file* has, as one who edits it leaves that in."""
    ids = [line for line in file.read_text().splitlines() if line.startswith("id = ")]
    file.write_text(text.replace("[home]", f"[home]\n{ids[0]}", 1))


def test_a_home_keeps_its_data_through_each_harmless_change(file: Path) -> None:
    file.write_text(VILLA + BROKER)
    keep(start(file), "lamp")
    for text in (VILLA + HUE + BROKER, VILLA + TLS + HUE, VILLA + HOST, CAPITAL + HOST, '[home]\nname = "Our home"\n'):
        moved(file, text)
        assert devices(start(file)) == ["lamp"]
        assert index_place(load_config(file), file) == start(file)


def test_the_id_is_written_beside_comments_and_once(file: Path) -> None:
    before = '\ufeff# ours\r\n[home]  # of us\r\nname = "villa"  # or so\r\n\r\n[door]\r\n'
    file.write_bytes(before.encode())
    file.chmod(0o640)
    home = start(file).parent.name
    written = f'[home]  # of us\r\nid = "{home}"  # made by homebot, which finds the data of this home by it\r\n'
    assert file.read_bytes().decode() == before.replace("[home]  # of us\r\n", written)
    assert file.stat().st_mode & 0o777 == 0o640
    seen = file.stat().st_mtime_ns
    start(file)
    assert file.stat().st_mtime_ns == seen


def test_the_id_is_written_beside_a_dotted_name(file: Path) -> None:
    file.write_text('# ours\nhome.name = "villa"  # or so\nhome.language = "de"\n' + BROKER)
    home = keep(start(file), "lamp").name
    written = f'home.id = "{home}"  # made by homebot, which finds the data of this home by it'
    assert file.read_text().splitlines()[:3] == ["# ours", written, 'home.name = "villa"  # or so']


@pytest.mark.parametrize("text", ['home = {name = "villa"}\n', "# only a comment"])
def test_a_file_in_which_no_line_can_be_added_or_with_no_table_is_known_by_its_path(file: Path, text: str) -> None:
    file.write_text(text)
    keep(start(file), "lamp")
    file.write_text(file.read_text() + "\n" + BROKER if text.startswith("#") else text + BROKER)
    assert devices(start(file)) == ["lamp"]


@pytest.mark.parametrize("text", [BROKER + VILLA, HUE + BROKER + VILLA, TLS + VILLA, HOST + VILLA, CAPITAL + BROKER])
def test_a_folder_of_an_earlier_version_is_moved_once_with_a_copy(file: Path, text: str) -> None:
    old = keep(index_path("villa", "10.0.0.1:1883"), "lamp")
    file.write_text(text)
    assert index_place(load_config(file), file).parent == old
    index = start(file)
    assert index.parent.parent.name == "homes"
    assert devices(index) == ["lamp"]
    (copy,) = old.parent.iterdir()
    assert devices(copy / "index.sqlite") == ["lamp"]
    assert start(file) == index
    assert list(unused_folders(index.parent)) == []


def test_if_several_folders_fit_none_is_taken_until_one_is_adopted(file: Path) -> None:
    first = keep(index_path("villa", "hue"), "new lamp").relative_to(file.parent / "data")
    second = keep(index_path("villa", "10.0.0.1:1883"), "lamp").relative_to(file.parent / "data")
    file.write_text(VILLA + HOST)
    index = keep(start(file), "newest lamp")
    assert [text.partition("homebot home adopt ")[2] for text in unused_folders(index)] == sorted(
        [str(first), str(second)]
    )
    adopted = adopt_folder(load_config(file), file, str(second))
    assert devices(start(file)) == ["lamp"]
    assert start(file).parent == adopted
    left = [text.partition("homebot home adopt ")[2] for text in unused_folders(adopted)]
    assert left == sorted([str(first), f"homes/{index.name}"])
    adopt_folder(load_config(file), file, f"homes/{index.name}")
    assert devices(start(file)) == ["newest lamp"]
    with pytest.raises(UsageError, match=r"attic is no folder of a home; known are homes/.*villa/hue"):
        adopt_folder(load_config(file), file, "attic")


@pytest.mark.parametrize("names", [("villa", "cabin"), ("villa", "villa"), ("home", "home")])
def test_two_homes_on_one_machine_stay_two(tmp_path: Path, names: tuple[str, str]) -> None:
    files = tmp_path / "a.toml", tmp_path / "b.toml"
    for file, name in zip(files, names, strict=True):
        file.write_text(f'[home]\nname = "{name}"\n{BROKER}')
        keep(start(file), file.name)
    assert [devices(start(file)) for file in files] == [["a.toml"], ["b.toml"]]
    with pytest.raises(UsageError, match=r"belongs to the home of .*a\.toml"):
        adopt_folder(load_config(files[1]), files[1], str(start(files[0]).parent))


def test_the_id_of_another_home_is_refused(tmp_path: Path, file: Path) -> None:
    file.write_text(VILLA + BROKER)
    keep(start(file), "lamp")
    copy = tmp_path / "cabin.toml"
    copy.write_text(file.read_text().replace("10.0.0.1", "10.0.0.9"))
    with pytest.raises(ConfigError, match=r"home\.id: is the id of the home of .*homebot\.toml; without this line"):
        start(copy)
    file.unlink()  # it was moved, and not copied
    assert devices(start(copy)) == ["lamp"]


def test_data_whose_configuration_names_others_are_told_as_unused(file: Path) -> None:
    file.write_text(VILLA + BROKER)
    first = keep(start(file), "lamp")
    file.write_text('[home]\nname = "attic"\n')
    second = start(file).parent
    assert first != second
    (text,) = unused_folders(second)
    assert text.startswith("data of the home villa, last used on ")


def test_without_a_file_each_broker_has_its_own_however_it_is_spelt(file: Path) -> None:
    def place(text: str) -> tuple[str, ...]:
        file.write_text(VILLA + text)
        return settle_home(load_config(file), None).parts[-3:]

    assert place("[gateways.mqtt]\n") == ("villa", "embedded", "index.sqlite")
    assert len({place(text) for text in (BROKER, TLS, HOST)}) == 3
    assert place(HOST) == place(HOST.replace("broker.lan", "Broker.lan:1883"))


def test_a_home_whose_id_came_with_its_file_gets_a_folder_here(file: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A file of another computer was told that the folder could not be written, at its first start."""
    file.write_text(f'[home]\nid = "{"ab" * 8}"\n{BROKER}')
    assert start(file).parent.is_dir()
    assert caplog.text == ""
