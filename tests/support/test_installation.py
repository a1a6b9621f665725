"""The identity of a homebot: the same after a restart, another for a second homebot, and never in the way."""

import json
import re
from pathlib import Path
from random import Random

import pytest

from homebot.support.installation import INSTALLATION_FILE, Installation


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "home" / INSTALLATION_FILE


def test_it_stays_the_same_over_a_restart_and_each_part_has_its_own(file: Path) -> None:
    first = Installation(file)
    found = first.id_of("/gateway/mdns")
    assert re.fullmatch("[0-9a-f]{16}", found)
    assert first.id_of("/network_services") != found
    first.close()
    assert Installation(file).id_of("/gateway/mdns") == found


def test_a_second_homebot_of_the_same_home_has_another_and_leaves_that_of_the_first(file: Path) -> None:
    first, second = Installation(file), Installation(file)
    ids = [first.id_of("x"), second.id_of("x")]
    assert ids[0] != ids[1]
    assert (first.problem, str(file) in second.problem) == ("", True)
    second.renew()
    second.store_name("robot", "robot-2")
    first.close()
    assert Installation(file).id_of("x") == ids[0]


def test_without_a_file_it_is_another_one_each_time_unless_it_is_seeded() -> None:
    assert Installation().id_of("x") != Installation().id_of("x")
    seeded = [Installation(random=Random(1)) for _ in range(2)]  # noqa: S311 - for a test
    assert seeded[0].id_of("x") == seeded[1].id_of("x")


def test_a_renewed_one_and_the_names_that_it_got_are_kept(file: Path) -> None:
    first = Installation(file)
    before = first.id_of("x")
    first.renew()
    first.store_name("robot", "robot-2")
    assert first.id_of("x") != before
    first.close()
    again = Installation(file)
    assert again.id_of("x") == first.id_of("x")
    assert (again.name_for("robot"), again.name_for("other")) == ("robot-2", "other")


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"\xff", b"[" * 5000, b"5", b'{"id": 5}', b'{"id": "x", "names": 7}', b'{"names": {"robot": 7}}'],
)
def test_a_damaged_file_costs_a_new_identity(file: Path, content: bytes) -> None:
    file.parent.mkdir()
    file.write_bytes(content)
    first = Installation(file)
    found = first.id_of("x")
    assert first.name_for("robot") == "robot"
    first.close()
    assert Installation(file).id_of("x") == found
    assert set(json.loads(file.read_bytes())) == {"id", "names"}


def test_a_file_that_cannot_be_made_is_told_of(tmp_path: Path) -> None:
    (tmp_path / "home").write_text("a file where the folder would be")
    installation = Installation(tmp_path / "home" / INSTALLATION_FILE)
    assert installation.id_of("x") == installation.id_of("x")
    assert str(tmp_path) in installation.problem
