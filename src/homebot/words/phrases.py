"""The forms of sentences: states, times, presses, people and robots, steps and wishes. Pure."""

from typing import Final

from homebot.words.tokens import Phrase

# States of devices, as triggers, conditions and steps that wait for one.
LASTING: Final = Phrase("{state} for {length:length}")
RECENT: Final = Phrase("{state} for less|under [than] {length:length}")
CHANCE: Final = Phrase("[by] chance 1 in {count:number}")
NOT: Final = Phrase("no|not {state}", "none of {state}")
ALL: Final = Phrase("all|every|each {state}")
MOTION: Final = Phrase("motion|presence|occupancy [{rest}]")

LIMIT: Final = Phrase(
    "{what:word} [where~of|in] [{area}] [is|drops|falls|rises] sign~below|above|under|over|<|> [{number:number}]"
)
PRESS: Final = Phrase("{query} press|pressed|presses [{value:one}]")

CHANGES: Final = Phrase(
    "{what} changes from {before} to {after} for {length:length}",
    "{what} changes from {before} to {after}",
    "{what} changes",
)
AT_TIME_OF: Final = Phrase("at told~text|value of {what}")
MESSAGE: Final = Phrase("message on {topic} with {value}", "message on {topic}")

# Times.
STARTS: Final = Phrase("homebot starts")
ELEVATION: Final = Phrase(
    "sun angle~elevation|height|azimuth [is] sign~above|below|over|under|<|<=|>|>= {degrees:amount}",
    "[the] sun is sign~above|below|over|under {degrees:amount}",
)
SUN_CROSSES: Final = Phrase(
    "sun angle~elevation|height|azimuth [rises|falls|drops] sign~above|below|over|under|<|> {degrees:amount}",
    "[the] sun rises|falls|drops|sinks sign~above|below|over|under {degrees:amount}",
)
CROSSES: Final = Phrase("{what} rises|climbs above|over {limit}", "{what} falls|drops|sinks below|under {limit}")
HOUSE_SPAN: Final = Phrase("between {begin} and {end}", "after {begin}", "before {end}")
INTERVAL: Final = Phrase("every {length:length}")
STARTED_BY: Final = Phrase("started by {what}")
ENDED_BY: Final = Phrase("[the] [last] wait ended by {what}")
TIMED_OUT: Final = Phrase("[the] [last] wait timed out")
TWO_VALUES: Final = Phrase(
    "{first} [is] sign~above|below|over|under {second} change~plus|minus {offset:number}",
    "{first} [is] sign~above|below|over|under {second}",
)
CALCULATED: Final = Phrase("sign~above|below|over|under {limit:number}")
SUN_VALUE: Final = Phrase("sun angle~elevation|height|azimuth")
NAMES: Final = Phrase("names with {capability} of", "names of")
LAST_RUN: Final = Phrase(
    "[the] last run [was] sign~over|above|under|below|before|within|less|more [than] {length:length} [ago]"
)
RUN_TODAY: Final = Phrase("[already] run|ran [already] today", "[the] last run [was] today")
SINCE_MOMENT: Final = Phrase("text of {what} [was|is] sign~over|more|under|less [than] {length:length} ago")

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
WAIT_UNTIL: Final = Phrase(
    "wait until {state} [,] at most {most} , then end~stop|go|continue [on]", "wait until {state} [,] at most {most}"
)
WAIT_FOR: Final = Phrase(
    "wait for {what} [,] at most {most} , then end~stop|go|continue [on]", "wait for {what} [,] at most {most}"
)
WAIT: Final = Phrase("wait {length:length} to {most:length}", "wait {length:length}")
NOTIFY: Final = Phrase("notify [:] {text}")
SWITCH_ROUTINE: Final = Phrase(
    "routine {name} way~on|off", "turn|switch way~on|off [the] routine {name}", "way~run|start [the] routine {name}"
)
SCENE: Final = Phrase("scene {name} , over {length:length}", "scene {name}")
OVER: Final = Phrase("over {length:length}")
SCENE_TARGET: Final = Phrase("scene {name}")
ARTICLE: Final = Phrase("the|a|an|my {name}")
EVERYTHING: Final = Phrase("everything|all [{rest}]")
DRIVE_VERBS: Final = ("go", "goes", "drive", "drives")
DRIVE: Final = Phrase(f"{{robot:word}} {'|'.join(DRIVE_VERBS)} to [the] {{room}}")
DIM: Final = Phrase("{target} way~dim|brighten|darken while {button} {event:one}")

HUE: Final = Phrase("color {value:number}")

VERB_FIRST: Final = (
    (Phrase("turn|set|switch [the] {target} do~on|off"), "{target} {do}"),
    (Phrase("turn|set|dim [the] {target} to {value}"), "{target} to {value}"),
    (Phrase("send|bring [the] {target} to [the] floor {value}"), "{target} floor {value}"),
    (
        Phrase("[turn|switch] do~on|off|open|close|toggle|lock|unlock|start|stop|pause|play [the] {target}"),
        "{target} {do}",
    ),
)
"""Commands with the verb first, and how they are written with the device first."""

MEANT_STEPS: Final = (
    (Phrase("wait for {length:length}"), "write", ("wait {length}",)),
    (Phrase("{do} [,] for {length:length}"), "write three steps,", ("{do}", "wait {length}", "undo")),
    (Phrase("{do} [,] over {length:length}"), "write", ("{do}, over {length}",)),
    (Phrase("{target} on at|with {value:amount}"), "write", ("{target} on, {value}",)),
    (Phrase("{target} at {value:amount}"), "write", ("{target} {value}",)),
    (Phrase("turn|switch way~on|off [the] routine"), "name it, like", ("routine Film {way}",)),
    *((form, "write the device first, like", (step,)) for form, step in VERB_FIRST),
)
"""How steps that are no command are written instead: a form, the advice, and the steps."""

# Wishes.
LIT: Final = Phrase("{room} [should] [is|are|be] [no~not] word~lit|bright|dark|alight|unlit")
IN_ROOM: Final = Phrase(
    "{robot:word} [should] [is|be] [no~not] in [the] {room}", "[send|bring] [the] {robot:word} to|into [the] {room}"
)
DOCKED: Final = Phrase(
    "{robot:word} [is] way~docked|charging",
    "[send|bring] [the] {robot:word} [is] [back] way~home",
    "{robot:word} [is] [back] way~at|in|on [the|its] dock|charger",
    "{robot:word} [is] [back] way~at|in|on [the|its] docking|charging station",
)
SCENE_WISH: Final = Phrase("[apply|start] scene {name}", "[apply|start] [the] {name} scene")
STATE_WISH: Final = Phrase(
    "{what} [should] [is|are|be] [no~not] {state:word} in {where}", "{what} [should] [is|are|be] [no~not] {state:word}"
)
AT_VALUE: Final = Phrase("{what} [should] [is|are|be] [set|on] at|to {value:number}")
THE: Final = Phrase("[make|keep] the {what}", "make|keep {what}")
LAST_ROOM: Final = Phrase("{what} in {room}")
ROOM: Final = Phrase("{name} room")
IS: Final = Phrase("{what} is|are")
NUMBERED: Final = Phrase("{rest} {number:number}")
