"""The list of descriptions and its changes."""

import json
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from homebot.bridges.thing_directory.catalog import MAX_CHANGE_BYTES, MAX_CHANGES, ThingCatalog, merge_patch

JSON = st.recursive(
    st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from("abcd"), inner, max_size=4),
    max_leaves=12,
)


def patched(target: Any, patch: Any) -> Any:
    """Apply a patch as RFC 7396, section 2, says."""
    if not isinstance(patch, dict):
        return patch
    result = dict(target) if isinstance(target, dict) else {}
    for name, value in patch.items():
        if value is None:
            result.pop(name, None)
        else:
            result[name] = patched(result.get(name), value)
    return result


@given(st.dictionaries(st.sampled_from("abcd"), JSON), st.dictionaries(st.sampled_from("abcd"), JSON))
def test_a_patch_makes_the_new_of_the_old(before: dict[str, object], after: dict[str, object]) -> None:
    assert patched(before, merge_patch(before, after)) == after


@given(st.lists(st.tuples(st.sampled_from("abcde"), st.integers(0, 3)), max_size=40))
def test_whoever_follows_the_changes_has_the_list(steps: list[tuple[str, int]]) -> None:
    catalog, copy = ThingCatalog(), dict[str, Any]()
    place = 0
    for name, number in steps:
        if number == 0:
            catalog.remove(name)
        else:
            catalog.put(name, {"id": name, "title": number}, "now")
        changes = catalog.changes_after(place)
        assert changes is not None
        for change in changes:
            place = change.number
            if change.name == "thing_deleted":
                del copy[change.id]
            else:
                copy[change.id] = patched(copy.get(change.id), json.loads(change.detail))
    listed = catalog.page(0, 100)
    assert {one.id: json.loads(one.text) for one in listed} == copy
    assert [one.id for one in listed] == sorted(copy)
    assert [one.id for one in catalog.page(0, 100, is_descending=True)] == sorted(copy, reverse=True)


def test_an_equal_description_changes_nothing() -> None:
    catalog = ThingCatalog()
    catalog.put("a", {"id": "a", "ops": ("x",)}, "2026-01-01")
    etag, version = catalog.page(0, 1)[0].etag, catalog.version
    catalog.put("a", {"id": "a", "ops": ["x"]}, "2026-01-02")
    assert (catalog.page(0, 1)[0].etag, catalog.version) == (etag, version)
    catalog.put("a", {"id": "a", "ops": []}, "2026-01-03")
    assert json.loads(catalog.page(0, 1)[0].text)["registration"] == {"created": "2026-01-01", "modified": "2026-01-03"}
    assert catalog.page(0, 1)[0].etag != etag


def test_the_last_changes_are_kept_and_a_reader_further_behind_gets_none() -> None:
    catalog = ThingCatalog()
    for number in range(MAX_CHANGES + 50):
        catalog.put("a", {"id": "a", "title": number}, "now")
    assert catalog.changes_after(0) is None
    assert catalog.changes_after(catalog.version + 1) is None
    changes = catalog.changes_after(catalog.version - MAX_CHANGES)
    assert changes is not None
    assert len(changes) == MAX_CHANGES


def test_long_changes_are_kept_up_to_a_limit() -> None:
    catalog = ThingCatalog()
    for number in range(10):
        catalog.put("a", {"id": "a", "title": f"{number}" * (MAX_CHANGE_BYTES // 4)}, "now")
    changes = catalog.changes_after(catalog.version - 3)
    assert changes is not None
    assert len(changes) == 3
    assert catalog.changes_after(catalog.version - 4) is None
