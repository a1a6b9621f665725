"""Scenes of the owner: saved, edited, applied, undone; in virtual time."""

import anyio
import pytest
from tests.control.conftest import Home, ignore
from tests.features.scenes.conftest import Kept, Scenes, served

from homebot.devices.value import PlainValue
from homebot.devices.wording.journal_words import trigger_text
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part

pytestmark = pytest.mark.virtual_time


def sent(home: Home) -> list[tuple[str, str, PlainValue]]:
    return sorted((one.key, one.capability, one.value.plain()) for one in home.commands)


async def evening(home: Home) -> None:
    """Two lamps and a blind of the living room, with their values."""
    for key, level in (("lamp", 20.0), ("shelf", 60.0)):
        home.put(key, "light", "on_off", "level", area="living")
        await home.report(key, "on_off", True)
        await home.report(key, "level", level)
    home.put("blind", "window_covering", "position", area="living")
    await home.report("blind", "position", 30.0)


async def test_the_present_values_are_saved_in_the_words_of_do(home: Home, scenes: Scenes) -> None:
    await evening(home)
    answer = await scenes.change(name="Film", change="save", target="in living")
    assert answer.success, answer.message
    assert await scenes.values("film") == {"Lamp": "on, 20 %", "Shelf": "on, 60 %", "Blind": "position 30 %"}


async def test_what_is_unknown_or_away_is_left_out_and_named(home: Home, scenes: Scenes) -> None:
    await evening(home)
    home.put("new", "light", "on_off", area="living")
    answer = await scenes.change(name="Film", change="save", target="light in living")
    assert {one.key: one.value for one in answer.left_out} == {"New": "its values are unknown"}
    assert [one.name for one in answer.scenes[0].parts] == ["Lamp", "Shelf"]


async def test_now_stands_for_the_present_values(home: Home, scenes: Scenes) -> None:
    await evening(home)
    home.put("new", "light", "on_off", area="living")
    now = [{"key": key, "value": "now"} for key in ("lamp", "blind")]
    assert (await scenes.change(name="Film", change="save", values=now)).success
    await home.report("lamp", "level", 40.0)
    await scenes.change(name="Film", change="edit", values=[{"key": "shelf", "value": "now"}])
    assert await scenes.values("Film") == {"Lamp": "on, 20 %", "Blind": "position 30 %", "Shelf": "on, 60 %"}
    answer = await scenes.change(name="Film", change="edit", values=[{"key": "new", "value": "now"}])
    assert answer.message.endswith("New was refused: nothing of it is known that a scene could bring back")


async def test_a_lamp_that_is_off_is_saved_as_off_alone(home: Home, scenes: Scenes) -> None:
    """Its level, or its colour, would turn it on."""
    home.put("lamp", "light", "on_off", "level")
    await home.report("lamp", "level", 20.0)
    await home.report("lamp", "on_off", False)
    await scenes.change(name="Night", change="save", target="lamp")
    assert await scenes.values("Night") == {"Lamp": "off"}


async def test_what_always_asks_is_saved_by_nobody_but_an_edit(home: Home, scenes: Scenes) -> None:
    home.put("door", "door_lock", "lock")
    await home.report("door", "lock", "unlocked")
    answer = await scenes.change(name="Leave", change="save", target="door")
    assert not answer.success
    assert "it always asks" in answer.message
    answer = await scenes.change(name="Leave", change="save", values=[{"key": "door", "value": "unlock"}])
    assert answer.success, answer.message
    assert answer.scenes[0].parts[0].asks == "it is a door lock"


async def test_a_scene_gives_each_part_its_values_and_answers_with_the_worst(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Film", change="save", target="in living")
    for key in ("lamp", "shelf"):
        await home.report(key, "on_off", False)
    await home.report("blind", "position", 100.0)
    home.behaviours["shelf"] = ignore
    answer = await scenes.apply("Film")
    assert not answer.success
    assert {one.name: one.result.outcome for one in answer.results} == {
        "Lamp": "confirmed",
        "Shelf": "no_answer",
        "Blind": "confirmed",
    }
    assert answer.outcome == "no_answer"
    assert answer.message.startswith("Shelf: no answer")


async def test_the_journal_says_which_scene_it_was(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Film", change="save", target="lamp")
    await home.report("lamp", "level", 80.0)
    await scenes.apply("Film")
    entries = (await home.read(device="memory/lamp")).entries or (await home.read()).entries
    assert {one.trigger.scene for one in entries if one.kind == "requested"} == {"Film"}
    assert {one.issuer for one in entries if one.kind == "requested"} == {"client:local"}


async def test_an_undo_brings_back_what_nobody_has_changed_since(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Dark", change="save", values=[{"key": "light in living", "value": "off"}])
    assert (await scenes.apply("Dark")).success
    await anyio.sleep(1)
    await home.report("shelf", "on_off", True)
    answer = await scenes.apply("Dark", undo=True)
    assert [(one.name, one.result.outcome) for one in answer.results] == [("Lamp", "confirmed")]
    asked = [one.trigger for one in (await home.read()).entries if one.kind == "requested"]
    assert [trigger_text(one, {}) for one in asked[-2:]] == ["the scene Dark was applied", "the scene Dark was undone"]
    again = await scenes.apply("Dark", undo=True)
    assert "nothing to undo" in again.message


async def test_an_undo_outlives_a_sudden_death_just_after_the_scene(home: Home, scenes: Scenes, kept: Kept) -> None:
    await evening(home)
    await scenes.change(name="Dark", change="save", values=[{"key": "light in living", "value": "off"}])
    assert (await scenes.apply("Dark")).success
    assert kept.on_disk == kept.record
    assert (await scenes.apply("Dark", undo=True)).success
    assert kept.on_disk == kept.record


async def test_an_edit_changes_what_is_named_and_keeps_the_rest(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Film", change="save", target="light in living")
    edits = [{"key": "lamp", "value": "off"}, {"key": "shelf", "value": ""}, {"key": "blind", "value": "10 %"}]
    answer = await scenes.change(name="film", change="edit", values=edits)
    assert answer.success, answer.message
    assert await scenes.values("Film") == {"Lamp": "off", "Blind": "position 10 %"}


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("on, off", "contradict each other"),
        ("off, 20 %", "contradict each other"),
        ("purple", "this part takes"),
        ("120 %", "from 0 to 1"),
        ("push", "push"),
    ],
)
async def test_values_that_make_no_sense_change_nothing(home: Home, scenes: Scenes, words: str, why: str) -> None:
    await evening(home)
    await scenes.change(name="Film", change="save", target="lamp")
    answer = await scenes.change(name="Film", change="edit", values=[{"key": "lamp", "value": words}])
    assert not answer.success
    assert why in answer.message
    assert await scenes.values("Film") == {"Lamp": "on, 20 %"}


async def test_a_code_is_never_kept(home: Home, scenes: Scenes) -> None:
    home.put("keypad", "x_setting", "text", name="Door code")
    answer = await scenes.change(name="In", change="save", values=[{"key": "Door code", "value": "text 4711"}])
    assert not answer.success
    assert "no scene keeps one" in answer.message
    assert "4711" not in scenes.kept.record


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "x" * 101, "\x1b[31mred", "---"])
async def test_a_name_that_cannot_be_shown_is_refused(home: Home, scenes: Scenes, name: str) -> None:
    await evening(home)
    answer = await scenes.change(name=name, change="save", target="lamp")
    assert "cannot name a scene" in answer.message


async def test_a_misspelt_name_is_answered_with_the_nearest(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Film", change="save", target="lamp")
    assert (await scenes.apply("Fim")).message == "there is no scene 'Fim'; did you mean Film?"


async def test_a_scene_can_be_renamed_and_removed(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Film", change="save", target="lamp")
    await scenes.change(name="Other", change="save", target="lamp")
    assert (await scenes.change(name="Film", change="rename", target="Other")).message
    assert (await scenes.change(name="Film", change="rename", target="Kino")).success
    assert (await scenes.change(name='"Other"', change="remove")).success
    assert [one.name for one in (await scenes.listed()).scenes] == ["Kino"]


async def test_a_device_that_has_gone_is_named_and_the_others_obey(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Film", change="save", target="light in living")
    home.gateway.devices.remove("shelf", "its battery is empty")
    await home.report("lamp", "on_off", False)
    answer = await scenes.apply("Film")
    assert [one.result.outcome for one in answer.results] == ["confirmed", "gone"]
    gone = (await scenes.shown("Film")).parts[1]
    assert not gone.is_known
    left = await scenes.change(name="Film", change="edit", values=[{"key": gone.name, "value": ""}])
    assert [one.name for one in left.scenes[0].parts] == ["Lamp"]


async def test_scenes_and_what_was_before_them_survive_a_restart(home: Home, kept: Kept) -> None:
    await evening(home)
    async with served(home, kept) as scenes:
        await scenes.change(name="Dark", change="save", values=[{"key": "lamp", "value": "off"}])
        await scenes.apply("Dark")
    async with served(home, kept) as scenes:
        answer = await scenes.apply("Dark", undo=True)
    assert [(one.name, one.result.outcome) for one in answer.results] == [("Lamp", "confirmed")]


async def test_a_scene_that_cannot_be_written_is_told(home: Home, scenes: Scenes, kept: Kept) -> None:
    await evening(home)
    kept.problem = "the disk is full"
    answer = await scenes.change(name="Film", change="save", target="lamp")
    assert answer.success
    assert answer.message == "a restart would lose this, as it was not written: the disk is full"


async def test_a_renamed_scene_can_still_be_undone(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Dark", change="save", values=[{"key": "lamp", "value": "off"}])
    await scenes.apply("Dark")
    await scenes.change(name="Dark", change="rename", target="Night")
    assert (await scenes.apply("Night", undo=True)).success


async def test_a_group_means_its_members(home: Home, scenes: Scenes) -> None:
    await evening(home)
    group = simple_part("light", settable=("on_off", "level")).model_copy(update={"members": ("id:one", "id:two")})
    home.gateway.devices.put(GatewayDevice("both", "Both", (group,), identifiers=("id:both",)), "it was found")
    for key in ("one", "two"):
        part = simple_part("light", settable=("on_off", "level"))
        home.gateway.devices.put(GatewayDevice(key, key.title(), (part,), identifiers=(f"id:{key}",)), "it was found")
        await home.report(key, "on_off", True)
    await scenes.change(name="Film", change="save", target="Both")
    assert await scenes.values("Film") == {"One": "on", "Two": "on"}
    await scenes.change(name="Film", change="edit", values=[{"key": "Both", "value": "30 %"}])
    assert await scenes.values("Film") == {"One": "30 %", "Two": "30 %"}


async def test_a_restart_in_the_middle_loses_no_value_from_before(home: Home, kept: Kept) -> None:
    await evening(home)
    home.behaviours["shelf"] = ignore
    async with served(home, kept) as scenes:
        await scenes.change(name="Dark", change="save", values=[{"key": "light in living", "value": "off"}])
        with anyio.move_on_after(1):  # the shelf has not answered yet
            await scenes.apply("Dark")
    async with served(home, kept) as scenes:
        answer = await scenes.apply("Dark", undo=True)
    assert [(one.name, one.result.outcome) for one in answer.results] == [("Lamp", "confirmed")]


async def test_of_two_scenes_at_once_each_part_obeys_one(home: Home, scenes: Scenes) -> None:
    await evening(home)
    await scenes.change(name="Dark", change="save", values=[{"key": "lamp", "value": "off"}])
    await scenes.change(name="Bright", change="save", values=[{"key": "lamp", "value": "on, 90 %"}])
    outcomes: dict[str, str] = {}

    async def apply(name: str) -> None:
        outcomes[name] = (await scenes.apply(name)).outcome

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(apply, "Dark")
        tasks.start_soon(apply, "Bright")
    assert sorted(outcomes.values()) in (["confirmed", "superseded"], ["confirmed", "confirmed"])


async def test_an_empty_house_has_no_scene_and_says_what_to_save(home: Home, scenes: Scenes) -> None:
    assert (await scenes.listed()).scenes == ()
    assert "no device fits" in (await scenes.change(name="Film", change="save", target="lights")).message
    assert "say what the scene is of" in (await scenes.change(name="Film", change="save")).message


async def test_there_is_a_limit_of_scenes(home: Home, scenes: Scenes) -> None:
    await evening(home)
    for number in range(300):
        assert (await scenes.change(name=f"Scene {number}", change="save", target="lamp")).success
    assert "remove one first" in (await scenes.change(name="More", change="save", target="lamp")).message
    assert (await scenes.change(name="Scene 7", change="save", target="shelf")).success


async def test_a_part_whose_device_has_another_id_is_found_by_its_route(home: Home, kept: Kept) -> None:
    """As after a merge with another announcement of the same device."""
    home.put("lamp", "light", "on_off")
    async with served(home, kept) as scenes:
        await scenes.change(name="Film", change="save", values=[{"key": "lamp", "value": "on"}])
    assert '"lamp":["memory/lamp#"]' in kept.record
    kept.record = kept.record.replace('"lamp"', '"lights/gone"')
    async with served(home, kept) as scenes:
        assert await scenes.values("Film") == {"Lamp": "on"}
        await scenes.change(name="Film", change="edit", values=[{"key": "lamp", "value": "off"}])
        assert await scenes.values("Film") == {"Lamp": "off"}
