"""``homebot find`` against a running homebot."""

import json
from pathlib import Path

import pytest
from tests.cli.test_guides import HOUSE
from tests.shell import homebot_in
from tests.whole_house import WHOLE_HOUSE

pytestmark = pytest.mark.slow


@WHOLE_HOUSE
def test_under_json_a_word_that_was_read_as_a_typo_is_noted_beside_the_list(tmp_path: Path) -> None:
    with homebot_in(tmp_path, house=HOUSE, until=("found front_door", "is running")) as homebot:
        found = homebot.run("homebot find fronnt --json")
    assert [one["name"] for one in json.loads(found.stdout)] == ["front_door"]
    note = "no device found has the word 'fronnt'; these have similar ones"
    assert json.loads(found.stderr) == {"note": note}
