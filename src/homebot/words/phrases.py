"""The forms of sentences: states, times, presses, people and robots, steps and wishes. Pure."""

from typing import Final

from homebot.words.tokens import Phrase

# States of devices, as triggers, conditions and steps that wait for one.
LASTING: Final = Phrase("{state} for {length:length}")
NO: Final = Phrase("no {state}", "none of {state}")
NOT: Final = Phrase("no|not {state}", "none of {state}")
ALL: Final = Phrase("all|every|each {state}")
MOTION: Final = Phrase("motion|presence|occupancy [{rest}]")
PLACED_LIMIT: Final = Phrase("{room} sign~below|above|under|over|<|<=|>|>= {limit}")
"""The words after ``in``, if a limit is among them."""

LIMIT: Final = Phrase(
    "{what:word} [in] [{area}] [is|drops|falls|rises] sign~below|above|under|over|<|> [{number:number}]"
)
PRESS: Final = Phrase("{query} press|pressed|presses [{value:one}]")

# Times that a routine does not know.
INTERVAL: Final = Phrase("every {length:length}")

# People and robots.
PERSON_IS: Final = Phrase("{who} is|are [no~not] [at] where~home|away")
PERSON_MOVES: Final = Phrase(
    "{who} comes~arrive|arrives|come|comes [home]",
    "{who} leave|leaves [home]",
    "{who} has|have left [home]",
    "{who} goes away [home]",
)
NOBODY: Final = Phrase("word~nobody|somebody [is] [sleeps~sleeps] in {room}")
ARRIVAL: Final = Phrase("{robot:word} word~arrives in {room}", "{robot:word} word~leaves {room}")

# Steps.
WAIT_UNTIL: Final = Phrase("wait until {state} [,] at most {most}")
WAIT: Final = Phrase("wait {length:length}")
NOTIFY: Final = Phrase("notify [:] {text}")
SCENE: Final = Phrase("scene {name} , over {length:length}", "scene {name}")
OVER: Final = Phrase("over {length:length}")
SCENE_TARGET: Final = Phrase("scene {name}")
ARTICLE: Final = Phrase("the|a|an|my {name}")
EVERYTHING: Final = Phrase("everything|all [{rest}]")
DRIVE: Final = Phrase("{robot:word} go|goes|drive|drives to [the] {room}")
DIM: Final = Phrase("{target} way~dim|brighten|darken while {button} {event:one}")

HUE: Final = Phrase("color {value:number}")

_FIRST: Final = "write the device first, like"
MEANT_STEPS: Final = (
    (Phrase("wait for {length:length}"), "write", ("wait {length}",)),
    (Phrase("{do} [,] for {length:length}"), "write three steps,", ("{do}", "wait {length}", "undo")),
    (Phrase("{do} [,] over {length:length}"), "write", ("{do}, over {length}",)),
    (Phrase("{target} on at|with {value:amount}"), "write", ("{target} on, {value}",)),
    (Phrase("{target} at {value:amount}"), "write", ("{target} {value}",)),
    (Phrase("turn|set {target} do~on|off"), _FIRST, ("{target} {do}",)),
    (Phrase("turn|set {target} to {value}"), _FIRST, ("{target} to {value}",)),
    (
        Phrase("[turn|switch] do~on|off|open|close|toggle|lock|unlock|start|stop|pause|play [the] {target}"),
        _FIRST,
        ("{target} {do}",),
    ),
)
"""How steps that are no command are written instead: a form, the advice, and the steps."""

# Wishes.
LIT: Final = Phrase("{room} [is|are] [no~not] word~lit|dark")
IN_ROOM: Final = Phrase("{robot:word} [is|are] [no~not] in [the] {room}")
DOCKED: Final = Phrase(
    "{robot:word} [is] way~docked|charging",
    "{robot:word} [is] [back] way~at|in|on [the|its] dock|charger",
    "{robot:word} [is] [back] way~at|in|on [the|its] docking|charging station",
)
SCENE_WISH: Final = Phrase("scene {name}", "{name} scene")
STATE_WISH: Final = Phrase("{what} [is|are] [no~not] {state:word} in {where}", "{what} [is|are] [no~not] {state:word}")
AT_VALUE: Final = Phrase("{what} [is|are] at {value:number}", "{what} [is|are] set to {value:number}")
THE: Final = Phrase("the {what}")
ROOM: Final = Phrase("{name} room")
IS: Final = Phrase("{what} is|are")
NUMBERED: Final = Phrase("{rest} {number:number}")
