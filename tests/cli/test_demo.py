"""``propmap demo`` needs nothing but what is installed, and says how good a name is."""

from __future__ import annotations

import re
import shlex

from .conftest import Run


def test_demo_says_how_good_a_name_is_and_what_to_do_next(run: Run) -> None:
    done = run("demo")
    assert done.code == 0 and not done.err
    shares = {
        line.split("│")[1].strip(): [int(share) for share in re.findall(r"(\d+) %", line)]
        for line in done.out.splitlines()
        if line.count(" %") == 3
    }
    assert [*shares] == ["thrust", "drag", "torque", "roll moment", "pitch moment"]
    # The hover model has no other loads than thrust and torque, and is worse at these.
    for load, (mine, inside, hover) in shares.items():
        # The bands exclude the differences between tunnels in thrust and torque.
        assert mine < hover and inside >= {"thrust": 50, "torque": 80}.get(load, 95), load
    assert all(shares[load][2] == 100 for load in ("drag", "roll moment", "pitch moment"))
    commands = re.findall(r"propmap (.+)", done.out)
    assert run(*shlex.split(commands[0])).code == 0
    assert run(*shlex.split(commands[1])).code == 0
