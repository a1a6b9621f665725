"""The HTTP API, asked by an independent client over real sockets."""

from pathlib import Path

import pytest
from tests.bridges.home_api.api import HISTORY, bearer, running_api


@pytest.mark.rooms("thesis")
async def test_a_house_is_found_commanded_and_explained(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        found = await api.get("/api/devices?q=light")
        assert [one["type"] for one in found.values["devices"]] == ["light"] * 4
        assert found.size < 600  # for what is 25 kB as the directory has it

        by_name = await api.get("/api/devices?q=door%20stop")
        assert [one["name"] for one in by_name.values["devices"]] == ["Door stop"], "its words mean doors"

        some = await api.get("/api/devices?limit=2")
        assert (len(some.values["devices"]), some.values["more"]) == (2, 3)

        turned_on = await api.command("lamp1", "turn on")
        assert (turned_on.status, turned_on.values["outcome"]) == (200, "confirmed"), turned_on
        dimmed = await api.command("lamp1", "level 40")
        assert (dimmed.values["outcome"], dimmed.values["evidence"]) == ("confirmed", "reported")

        lamp = (await api.get(f"/api/devices/{turned_on.values['id']}")).values
        assert (lamp["on"], lamp["level"], lamp["takes"]["level"]) == (True, 40, "0 to 100 %")
        lock = (await api.get("/api/devices/front_door")).values
        assert lock["always_asks"] == "it is a door lock"

        why = (await api.get("/api/why/lamp1")).values
        assert "the client local asked for level 40 %" in why["why"]
        assert any("lamp1 reported" in step for step in why["steps"])
        why_not = (await api.get("/api/why/lamp1?state=off")).values
        assert (why_not["is_so"], why_not["why"]) == (False, "no command asked for that")
        await api.command("lamp1", "level 50")
        why_not = (await api.get("/api/why/lamp1?state=40")).values["why"]
        assert why_not.endswith("(reported); it changed after that: a question without a state has the reason")
        is_so = (await api.get("/api/why/lamp1?state=50")).values
        assert (is_so["is_so"], is_so.get("steps")) == (True, None)

        home = (await api.get("/api/home")).values
        assert (home["home"], home["rooms"]) == ("villa", {"(no room)": {"light": 4, "door_lock": 1}})


async def test_a_session_that_may_not_unlock_cannot_and_hears_why(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        refused = await api.command("front_door", "unlock", Authorization=bearer("agent"))
        assert (refused.status, refused.content_type) == (403, "application/problem+json")
        assert refused.values["outcome"] == "refused"
        assert "such a device needs a right that names it" in refused.values["detail"]
        why = (await api.get("/api/why/front_door?state=unlocked", Authorization=bearer("agent"))).values
        assert not why["is_so"]
        assert "the client agent: refused (rights)" in why["why"]

        unlocked = await api.command("front_door", "unlock", Authorization=bearer("keys"))
        assert (unlocked.status, unlocked.values["outcome"]) == (200, "confirmed")


async def test_a_token_with_the_right_ask_unlocks_once_a_person_says_yes(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        async with api.answering(False, True) as asked:
            refused = await api.command("front_door", "unlock", Authorization=bearer("asker"))
            opened = await api.command("front_door", "lock", Authorization=bearer("asker"))
        assert (refused.status, refused.values["outcome"], refused.values["policy"]) == (200, "refused", "ask")
        assert refused.values["reason"] == "client:local said no"
        assert opened.values["outcome"] in {"confirmed", "already_so"}
        assert asked == [f"the client asker wants: locks/front_door → {to}" for to in ("unlocked", "locked")]
        why = (await api.get("/api/why/front_door?state=unlocked")).values
        assert "refused (ask): client:local said no" in str(why)
        assert (await api.command("lamp1", "on", Authorization=bearer("asker"))).values["outcome"] == "confirmed"


async def test_several_devices_are_commanded_at_once_and_nothing_is_sent_if_one_is_unknown(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        for near in ("lamp9", "Door stob", "Door sto", "lmp4"):
            unknown = await api.command(["lamp1", near], "on")
            assert (unknown.status, (await api.get("/api/devices/lamp1")).values["on"]) == (404, False)
        done = await api.command(["lamp1", "lamp2", "lamp2"], "on")
        assert (done.values["outcome"], [one["outcome"] for one in done.values["devices"]]) == (
            "confirmed",
            ["confirmed"] * 2,
        )
        mixed = await api.command(["lamp1", "front_door"], "unlock", Authorization=bearer("agent"))
        assert (mixed.status, mixed.values["outcome"], len(mixed.values["devices"])) == (200, "refused", 2)
        assert all(one["outcome"] == "refused" for one in mixed.values["devices"])
        nothing = await api.command([], "on")
        many = await api.command(["lamp1"] * 51, "on")
        assert (nothing.status, many.status) == (400, 400)


async def test_all_that_words_mean_is_commanded_at_once_but_nothing_that_always_asks(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        done = await api.command("all lights", "on")
        assert (done.values["outcome"], done.values["id"]) == ("confirmed", "all lights")
        assert {*done.values["parts"]} == {"lamp1", "lamp2", "lamp3", "Door stop"}
        for wrong in ("all ligths", "all lights in attic"):
            assert (await api.command(wrong, "off")).status == 404
        unlocked = await api.command("everything", "unlock", Authorization=bearer("keys"))
        assert (unlocked.status, unlocked.values["outcome"]) == (403, "refused")
        assert "a person must agree: front_door (it is a door lock)" in unlocked.values["detail"]
        entries = (await api.get("/api/journal?since=1h")).values["entries"]
        assert sum(" for on" in entry for entry in entries) == sum("confirmed" in entry for entry in entries) == 4
        one = (await api.get("/api/journal?device=lamp2&limit=1")).values
        assert (one["entries"][0].split(" ", 1)[1][:16], one["has_more"]) == ("lamp2: confirmed", True)


@pytest.mark.rooms("thesis", "history")
async def test_the_history_is_read_and_mistakes_are_named(tmp_path: Path) -> None:
    of_lamp = "/api/history?device=lamp1"
    async with running_api(tmp_path, **HISTORY) as api:
        await api.command("lamp1", "on")
        await api.until(f"{of_lamp}&capability=on_off", lambda found: bool(found.get("series")))
        history = (await api.get(f"{of_lamp}&capability=on_off&since=1h")).values
        misspelt = await api.get(f"{of_lamp}&capability=on_of")
        soon = await api.get(f"{of_lamp}&since=soon")
        unknown = await api.get("/api/history?device=Door%20stob")
    assert history["series"][0]["points"][-1][1] is True
    assert (misspelt.status, misspelt.values["detail"][-21:]) == (400, " did you mean on_off?")
    told = "no device fits 'Door stob'; did you mean Door stop?"
    for answer, status, detail in ((soon, 400, "'soon' is not a duration"), (unknown, 404, told)):
        assert (answer.status, answer.content_type) == (status, "application/problem+json")
        assert detail in answer.values["detail"]


async def test_a_mistake_is_told_with_its_remedy(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        asked = [
            (await api.command("lmp1", "on"), 404, "did you mean lamp1"),
            (await api.command("light", "on"), 409, "several devices fit 'light'; give the id of one: "),
            (await api.get("/api/devices/nothing"), 404, "no device fits 'nothing'"),
            *[
                (await api.get(f"/api/{route}"), 404, "no device fits 'Door stob'; did you mean Door stop?")
                for route in ("devices/Door%20stob", "why/Door%20stob")
            ],
            *[(await api.command(near, "on"), 404, "did you mean Door stop?") for near in ("Door stob", "Door sto")],
            *[
                (await api.get(f"/api/{route}"), 400, "contains no search term")
                for route in ("devices?q=%C2%A3", "devices/%C2%A3", "why/%C2%A3")
            ],
            (await api.command("£", "on"), 400, "contains no search term"),
            (await api.get("/api/devices?limit=201"), 400, "limit: Input should be less than or equal to 200"),
            (await api.command([], "on"), 400, "device: Tuple should have at least 1 item"),
            (await api.command(["lamp1"] * 51, "on"), 400, "device: Tuple should have at most 50 items"),
            (await api.get("/api/devices?quest=x"), 400, "known are q, limit"),
            (await api.get("/api/device"), 404, "there are GET /api/home"),
            (await api.get("/api/command"), 405, "/api/command takes POST"),
            (await api.get("/api/home", Authorization="Bearer wrong"), 401, "a valid token is needed"),
        ]
        refused = await api.command("lamp1", "fly")  # a word that the lamp does not take is an outcome
    for answer, status, detail in asked:
        assert (answer.status, answer.content_type) == (status, "application/problem+json"), answer
        assert detail in answer.values["detail"]
        assert answer.values["status"] == status

    assert (refused.status, refused.values["outcome"]) == (200, "refused")
    assert "this part takes on, off" in refused.values["reason"]


async def test_a_question_that_nothing_fits_has_the_reason(tmp_path: Path) -> None:
    lamps = "door stop, lamp1, lamp2, lamp3"
    async with running_api(tmp_path) as api:
        for question, note in (
            ("Which%20lights%20are%20on%3F", f"none now; in another state there would be {lamps}"),
            ("kettle", "no device has the word 'kettle'"),
            ("fan", "nothing matches; without a query all are listed"),
        ):
            assert (await api.get(f"/api/devices?q={question}")).values == {"devices": [], "note": note}
        await api.command("lamp1", "on")
        lit = (await api.get("/api/devices?q=what%20is%20on%3F")).values
        assert ([one["id"] for one in lit["devices"]], "note" in lit) == (["lights/lamp1"], False)


@pytest.mark.rooms("thesis", "scenes")
async def test_scenes_are_listed_applied_and_undone_with_the_outcome_of_each_part(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        await api.command(["lamp1", "lamp2"], "40 %")
        assert (await api.scene("Film")).status == 404
        await api.save("Film", {"lamp1": "20 %", "lamp2": "off", "front_door": "unlock"})
        listed = (await api.get("/api/scenes")).values["scenes"]
        assert listed == [{"scene": "Film", "parts": {"lamp1": "20 %", "lamp2": "off", "front_door": "lock unlocked"}}]

        applied = await api.scene("film", Authorization=bearer("agent"))
        assert (applied.status, applied.values["outcome"]) == (200, "refused")
        assert applied.values["parts"]["lamp2"].startswith("confirmed")
        assert "such a device needs a right" in applied.values["parts"]["front_door"]

        undone = await api.scene("film", undo=True)
        assert undone.values["outcome"] == "confirmed"
        assert sorted(undone.values["parts"]) == ["lamp1", "lamp2"]


@pytest.mark.rooms("thesis", "routines")
async def test_a_routine_is_proposed_by_who_may_act_and_mistakes_are_named(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        text = 'name = "Late"\nwhen = ["23:00"]\ndo = ["lamp1 off"]\n'
        done = await api.propose(text, Authorization=bearer("agent"))
        assert (done.status, done.values) == (
            200,
            {"text": "proposed Late; the owner enables it: homebot routine enable 'Late'"},
        )
        wrong = await api.propose(text.replace("off", "of"), Authorization=bearer("agent"))
        assert (wrong.status, "did you mean off" in wrong.values["detail"]) == (400, True)
        refused = await api.propose(text, Authorization=bearer("reader"))
        assert (refused.status, refused.values["outcome"]) == (403, "refused")


@pytest.mark.rooms("thesis", "goals")
async def test_a_goal_is_planned_for_who_may_act_and_a_mistake_is_named(tmp_path: Path) -> None:
    async with running_api(tmp_path) as api:
        done = await api.achieve("lamp1 on and lamp2 off", Authorization=bearer("agent"))
        assert (done.status, done.values["reached"]) == (200, True)
        asks = await api.achieve("front_door unlocked", Authorization=bearer("asker"))
        assert asks.values["steps"] == ["unlock front_door (asks first: its client may only ask)"]
        wrong = await api.achieve("lamp1", Authorization=bearer("agent"))
        assert (wrong.status, wrong.values["reached"]) == (200, False)
        assert "names no device or no state" in wrong.values["text"]
        refused = await api.achieve("lamp1 on", Authorization=bearer("reader"))
        assert (refused.status, refused.values["outcome"]) == (403, "refused")


@pytest.mark.rooms("habits", "history")
async def test_an_agent_reads_the_habits(tmp_path: Path) -> None:
    async with running_api(tmp_path, **HISTORY) as api:
        await api.until("/api/habits", lambda found: found == {"habits": []})  # the history begins later
