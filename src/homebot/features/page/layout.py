"""Changes of the layout. Pure."""

from typing import Final

from pydantic import BaseModel, ConfigDict, ValidationError

from homebot.errors import RefusedError, UsageError, WireError
from homebot.features.page.messages import ChangeLayoutRequest, PageLayout
from homebot.messages.key_value import KeyValue
from homebot.support.printable import printable

_MAX_NAMES: Final = 500
_MAX_LENGTH: Final = 200
_MAX_SHOWN: Final = 3


class LayoutBook(BaseModel):
    """The layout, and the one before the last change."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    layout: PageLayout = PageLayout()
    before: PageLayout = PageLayout()


def read_book(record: str) -> LayoutBook:
    """Return the book that was kept as *record*; a new one if that is empty.

    Raises:
        WireError: It cannot be read.
    """
    try:
        return LayoutBook.model_validate_json(record) if record else LayoutBook()
    except ValidationError as exc:
        raise WireError(f"no layout: {exc.errors()[0]['msg']}", record[:100].encode(errors="replace")) from exc


def change_layout(book: LayoutBook, request: ChangeLayoutRequest) -> LayoutBook:
    """Return *book* after the change.

    Raises:
        UsageError: It names nothing, or something that cannot be a name.
        RefusedError: There would be too many names, or there is nothing to undo.
    """
    now = book.layout
    if request.change == "undo":
        if not now.undoes:
            raise RefusedError("an undo of the layout", "nothing was changed yet")
        return LayoutBook(layout=book.before.model_copy(update={"undoes": now.undoes}), before=now)

    names = tuple(dict.fromkeys(request.names))
    if not names:
        raise UsageError(f"the change {request.change!r} of the layout has no names")
    for name in (*names, request.icon):
        if printable(name, _MAX_LENGTH) != name:
            raise UsageError(f"{name[:_MAX_LENGTH]!r} cannot be a name: give up to {_MAX_LENGTH} printable characters")

    if request.change == "icon":
        field, known = "icons", {icon.key: icon for icon in now.icons if icon.key not in names}
        icons = {name: KeyValue(key=name, value=request.icon) for name in names if request.icon}
        value: tuple[object, ...] = tuple((known | icons).values())
    else:
        field, value = request.list, _changed_list(getattr(now, request.list), request.change, names)
    if len(value) > _MAX_NAMES:
        raise RefusedError(f"the {field} of the page", f"there may be {_MAX_NAMES}; remove one first")
    if value == getattr(now, field):
        return book
    shown = ", ".join(names[:_MAX_SHOWN]) + (", …" if len(names) > _MAX_SHOWN else "")
    after = now.model_copy(update={field: value, "undoes": f"{request.change} {field}: {shown}"})
    return LayoutBook(layout=after, before=now)


def _changed_list(listed: tuple[str, ...], change: str, names: tuple[str, ...]) -> tuple[str, ...]:
    others = tuple(name for name in listed if name not in names)
    match change:
        case "order":
            return names + others
        case "remove":
            return others
        case _:
            return listed + tuple(name for name in names if name not in listed)
