"""What an attack is made of."""

import dataclasses
import typing

from .judge import PEAK_MB, judge
from .program import Conditions


@dataclasses.dataclass
class Case:
    label: str  # what is tried, in a few words
    arguments: list = dataclasses.field(default_factory=list)  # of the program
    prepare: typing.Callable = lambda arena: None  # damages the arena
    conditions: Conditions = dataclasses.field(default_factory=Conditions)
    needs_location: bool = False
    echoes: str = ""  # what a message may repeat
    heard: bool = True  # stderr can be written
    peak_mb: float = PEAK_MB
    anywhere: bool = False  # results may lie in another folder than `out`
    after: typing.Callable = lambda arena, outcome: []  # more findings

    def attack(self, arena):
        """Runs it once; the outcome's command and the findings."""
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
