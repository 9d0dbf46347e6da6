"""The definition of an attack, and the commands that are attacked."""

import dataclasses
import typing

from .judge import PEAK_MB, judge
from .program import Conditions


@dataclasses.dataclass
class Case:
    label: str  # short description
    arguments: list = dataclasses.field(default_factory=list)  # command line of the program
    prepare: typing.Callable = lambda arena: None  # damages the arena
    conditions: Conditions = dataclasses.field(default_factory=Conditions)
    needs_location: bool = False
    echoes: str = ""  # text of the attack that a message may repeat
    heard: bool = True  # stderr is writable
    peak_mb: float = PEAK_MB
    anywhere: bool = False  # results may be in another folder than `out`
    after: typing.Callable = lambda arena, outcome: []  # returns further findings

    def attack(self, arena):
        """Runs the attack once. Returns the outcome and the findings."""
        self.prepare(arena)
        if self.conditions.as_nobody:
            arena.open_for_nobody()
        arena.remember()
        outcome = arena.base.program.run(self.arguments, arena.folder, self.conditions)
        findings = judge(outcome, arena, self.needs_location, self.echoes, self.heard, self.peak_mb,
                         self.anywhere)
        findings += self.after(arena, outcome)
        return outcome, findings


CALIBRATE = ["calibrate", "flight", "--out", "out"]
GAUSS_HELMERT = ["calibrate", "flight", "--method", "gh", "--out", "out"]
SMOOTH = ["smooth", "flight", "--out", "out"]
CHECK = ["check", "flight", "--out", "out"]
ALL = ["calibrate", "flight", "--method", "all", "--out", "out"]
MATCH = ["match", "flight", "--out", "out"]
GEOREF = ["georef", "flight", "--boresight", "0.1,0.2,0.3", "--covariance", "--out", "out"]
