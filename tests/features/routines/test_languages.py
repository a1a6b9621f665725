"""The page offers ready-made routines in the language of the owner."""

from tests.web.test_languages import TABLE

from homebot.features.routines.gallery import gallery


def test_ready_made_routines_are_translated() -> None:
    texts = {one.about for one in gallery().values()}
    texts |= {key.replace("_", " ") for one in gallery().values() for key in one.inputs}
    assert texts - TABLE.keys() == set()
