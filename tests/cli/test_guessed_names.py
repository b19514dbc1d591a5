"""Options and commands under the names of other tools are answered with propmap's own."""

from __future__ import annotations

import tomllib

import pytest

from propmap.cli.app import ANSWERS, Commands, main


@pytest.mark.parametrize(
    ("typed", "answer"),
    [
        ("predict apc-8x6e --omega 600", "use --rpm, in rpm"),
        ("predict apc-8x6e --rpm 6000 --airspeed 5", "use --speed in m/s"),
        ("trim quad.toml --velocity=5", "use --speed in m/s"),
        ("predict apc-8x6e --throttle 0.5", "propmap trim VEHICLE.toml"),
        ("predict apc-8x6e --rpm 3000:6000:4", "propmap sweep PROP --rpm 3000:6000:4"),
        ("loads apc-8x6e", "use propmap predict"),
        ("trim quad.toml --omega 600", "see propmap trim --help"),  # trim computes the rotor speed
        ("fit search", "see propmap fit --help"),
    ],
)
def test_a_guess_is_answered(typed: str, answer: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(typed.split()) == 2
    line = capsys.readouterr().err
    assert answer in line and line.count("\n") == 1


def test_no_answer_hides_a_real_name() -> None:
    """An option or command that exists is never a guess at another one."""
    answers = tomllib.loads(ANSWERS.read_text(encoding="utf-8"))
    assert set(answers["commands"]) <= set(Commands.places)
    guesses = " ".join(answers["commands"].values()).split()
    assert len(guesses) == len(set(guesses)) and not set(guesses) & set(Commands.places)
    options = " ".join(one["typed"] for one in answers["options"]).split()
    assert len(options) == len(set(options))
