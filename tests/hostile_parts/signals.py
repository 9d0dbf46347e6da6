"""Signals at random moments: SIGKILL must leave no half-written file, others must end the run."""

import json
import os
import re
import signal

from .cases import CALIBRATE, GAUSS_HELMERT, SMOOTH, Case
from .judge import LEFTOVER
from .program import Conditions

POLITE = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
SOON_S = 2.0  # longest time from a signal to the end of the program, on a busy machine
SIMULATE = ["simulate", "scenario.yaml", "--out", "out"]
MONTE_CARLO = ["monte-carlo", "scenario.yaml", "--flights", "3", "--out", "out"]
COMMANDS = [CALIBRATE, CALIBRATE, SMOOTH, GAUSS_HELMERT, SIMULATE, MONTE_CARLO]
LONGEST_MOMENT_S = 1.2  # latest time of a signal; most runs have ended by then


def half_written(folder):
    """Returns the names of incomplete result files."""
    broken = []
    for root, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(root, name)
            if not LEFTOVER.search(os.path.relpath(path, folder)) and not is_whole(path):
                broken.append(name)
    return broken


def is_whole(path):
    with open(path, "rb") as stream:
        content = stream.read()
    if path.endswith(".json"):
        try:
            json.loads(content)
        except ValueError:
            return False
        return True
    if path.endswith(".out"):
        return len(content) > 0 and len(content) % 136 == 0
    if path.endswith(".svg"):
        return content.rstrip().endswith(b"</svg>")
    return not path.endswith((".txt", ".yaml")) or content.endswith(b"\n")


# Unfinished record of a series that was killed while writing it. The next run removes it.
UNFINISHED_RECORD = re.compile(r"^here/out/(flights|records)/\.\d+\.json\.\d+\.part$")


def run_again(arena, arguments, as_nobody=False):
    """Checks that the next run into the same folder works and removes leftovers."""
    again = arena.base.program.run(arguments, arena.folder, Conditions(as_nobody=as_nobody))
    findings = []
    if again.exit_code != 0:
        findings.append(("next run", f"exit {again.exit_code}: {again.err[-300:]}"))
    left = [name for root, folders, files in os.walk(arena.here) for name in folders + files
            if LEFTOVER.search(name)]
    if left:
        findings.append(("leftover", f"after the next run: {', '.join(sorted(left)[:3])}"))
    return findings


class Killed(Case):
    """Sends SIGKILL. All files in the folder must be complete, and the next run must work."""

    def attack(self, arena):
        self.prepare(arena)
        earlier = self.earlier and arena.base.program.run(self.arguments, arena.folder)
        arena.remember()
        outcome = arena.base.program.run(self.arguments, arena.folder, self.conditions)
        findings = [("hang", "after SIGKILL")] if outcome.timed_out else []
        findings += [("half written", name) for name in half_written(arena.out)]
        findings += mixed(arena.out) if earlier else []
        return outcome, findings + run_again(arena, self.arguments)


def mixed(folder):
    """Returns a finding if the results of a run are published only in part."""
    names = set(os.listdir(folder)) if os.path.isdir(folder) else set()
    if "result.json" in names and "report.json" not in names:
        return [("half written", "result.json without report.json")]
    return []


class Interrupted(Case):
    """Sends another signal. The run must soon exit with 130, without results or leftovers."""

    expected_exits = (0, 130)

    def attack(self, arena):
        self.prepare(arena)
        arena.remember()
        outcome = arena.base.program.run(self.arguments, arena.folder, self.conditions)
        moment, number = self.conditions.signals[0]
        before_main = outcome.signal == number and not arena.out.exists()
        findings = []
        if outcome.timed_out:
            findings.append(("hang", f"after signal {number} at {moment:.3f} s"))
        elif outcome.seconds > moment + SOON_S * (10 if arena.base.program.sanitized else 1):
            findings.append(("signal",
                             f"ended {outcome.seconds - moment:.1f} s after signal {number}"))
        if outcome.exit_code not in self.expected_exits and not before_main and not outcome.timed_out:
            findings.append(("signal", f"exit {outcome.exit_code}, signal {outcome.signal}: "
                             f"{outcome.err[-200:]}"))
        if outcome.exit_code == 130 and any(n.startswith("result") for n in os.listdir(arena.out)):
            findings.append(("half written", "exit 130, but a result exists"))
        findings += self.left_over(arena)
        if any(UNFINISHED_RECORD.search(path) for path in arena.contents()):
            findings += run_again(arena, self.arguments)
        return outcome, findings

    @staticmethod
    def left_over(arena):
        left = [path for path in sorted(set(arena.contents()) - set(arena.before))
                if LEFTOVER.search(path) and not UNFINISHED_RECORD.search(path)
                or not path.startswith("here/out")]
        changed = [path for path, content in arena.before.items()
                   if content != "special" and arena.contents().get(path) != content]
        return [("leftover", path) for path in left] + [("input changed", path) for path in changed]


class Waiting(Interrupted):
    """Sends the signal while the program waits for a file. The program may also reject the file."""

    expected_exits = (1, 2, 130)


def lay_scenario(arena):
    (arena.here / "scenario.yaml").write_text(arena.base.scenario)


def lay_fifo(arena):
    """Replaces IMU.txt by a pipe without a writer. The program waits for it or rejects it."""
    lay_scenario(arena)
    path = arena.flight / "IMU.txt"
    path.unlink()
    os.mkfifo(path)


def case(base, rng, number):
    command = rng.choice(COMMANDS)
    moment = rng.choice([0.0, rng.uniform(0, 0.1), rng.uniform(0, LONGEST_MOMENT_S)])
    if number % 2 == 0:
        killed = Killed(f"{command[0]} killed after {moment:.3f} s", command, lay_scenario,
                        Conditions(signals=((moment, signal.SIGKILL),)))
        killed.earlier = rng.random() < 0.3
        return killed
    kind = rng.choice(POLITE)
    if rng.random() < 0.15:
        return Waiting(f"IMU.txt is a FIFO, {kind.name} after {moment:.3f} s", CALIBRATE, lay_fifo,
                       Conditions(signals=((moment, kind),), time_limit_s=10))
    sent = ((moment, kind),)
    if rng.random() < 0.3:
        sent += ((moment + 0.01, kind),)
    return Interrupted(f"{command[0]}, {kind.name} after {moment:.3f} s, {len(sent)} times",
                       command, lay_scenario,
                       Conditions(signals=sent))
