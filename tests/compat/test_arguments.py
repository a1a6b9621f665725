"""The ``--ros-args`` of a program, as ROS's documentation of node arguments writes them."""

from homebot.compat.arguments import node_rules, remove_ros_args


def test_names_and_parameters_are_those_of_all_nodes_or_of_the_named_one() -> None:
    words = "talker.py --ros-args -r chatter:=/hello -r talker:__node:=speaker -r other:a:=b --remap __ns:=/demo"
    names, parameters = node_rules([*words.split(), "-p", "talker:rate:=2.5", "--param", "other:x:=1"], "talker")
    assert names == {"chatter": "/hello", "__node": "speaker", "__ns": "/demo"}
    assert parameters == {"rate": 2.5}


def test_values_of_parameters_have_the_kind_that_yaml_gives_them() -> None:
    texts = {"1": 1, "1.5": 1.5, "true": True, "hello": "hello", "'1'": "1", "[1, 2]": [1, 2], "['a', 'b']": ["a", "b"]}
    for text, value in texts.items():
        assert node_rules(["--ros-args", "-p", f"x:={text}"], "n")[1] == {"x": value}


def test_the_arguments_of_the_program_itself_are_the_others() -> None:
    words = "prog -n 3 --ros-args -p x:=1 -- file --ros-args --log-level debug"
    assert remove_ros_args(words.split()) == ["prog", "-n", "3", "file"]
