"""Several runs at once into one folder, or one run that reads the file another one writes."""

import json
import os
import shutil

from .cases import ALL, CALIBRATE, GAUSS_HELMERT, SMOOTH, Case
from .judge import judge_boresight, judge_end
from .program import Conditions, Process
from .signals import half_written, lay_scenario, run_again

OTHER = ["calibrate", "other", "--out", "out"]


def lay_other(arena):
    """Makes a second flight that differs in its name and in the sigma of its pairs."""
    lay_scenario(arena)
    shutil.copytree(arena.flight, arena.here / "other")
    yaml = (arena.here / "other" / "flight.yaml").read_text()
    yaml = yaml.replace("name: small", "name: other").replace("sigma_p_m: 0.0577",
                                                              "sigma_p_m: 0.0677")
    (arena.here / "other" / "flight.yaml").write_text(yaml)


class Race(Case):
    def attack(self, arena):
        self.prepare(arena)
        arena.remember()
        program = arena.base.program
        runs = [Process(program, words, arena.folder, Conditions()) for words in self.competitors]
        outcomes = [run.finish() for run in runs]
        findings = []
        for outcome in outcomes:
            findings += judge_end(outcome, arena)
        if all(outcome.exit_code != 0 for outcome in outcomes):
            findings.append(("race", f"none of the runs succeeded: {outcomes[0].err[-200:]}"))
        findings += [("half written", name) for name in half_written(arena.out)]
        findings += self.one_run(arena)
        return outcomes[0], findings + run_again(arena, CALIBRATE)

    @staticmethod
    def one_run(arena):
        """Returns a finding if the results belong to several flights."""
        names = set()
        for file in ("result.json", "report.json"):
            path = arena.out / file
            if path.exists():
                names.add(json.loads(path.read_text()).get("flight"))
        names.discard(None)
        resolved = arena.out / "config.resolved.yaml"
        if names and resolved.exists() and 'name: "' in resolved.read_text():
            names.add(resolved.read_text().split('name: "')[1].split('"')[0])
        return [("race", f"results of {sorted(names)} in one folder")] if len(names) > 1 else []


class Rewritten(Case):
    """Reads a trajectory while another run writes it."""

    def attack(self, arena):
        self.prepare(arena)
        program = arena.base.program
        words = ["calibrate", "flight", "--method", "gh", "--trajectory", "smooth/trajectory.out",
                 "--out", "out"]
        program.run(["smooth", "flight", "--out", "smooth"], arena.folder)
        writer = Process(program, ["smooth", "flight", "--out", "smooth"], arena.folder,
                         Conditions())
        findings, outcome = [], None
        for _ in range(3):
            outcome = program.run(words, arena.folder)
            findings += judge_end(outcome, arena)
            path = arena.out / "result.json"
            if outcome.exit_code == 0 and path.exists():
                findings += judge_boresight(outcome, json.loads(path.read_text()), arena.truth_deg)
        findings += judge_end(writer.finish(), arena)
        return outcome, findings


def case(base, rng, number):
    if number % 4 == 3:
        return Rewritten("gh reads a trajectory while smooth writes it", prepare=lay_other)
    pool = [CALIBRATE, CALIBRATE, OTHER, SMOOTH, GAUSS_HELMERT, ALL]
    competitors = [rng.choice(pool) for _ in range(rng.randrange(2, 6))]
    race = Race(f"{len(competitors)} runs into one folder: " + ", ".join(c[1] + " " + c[-3]
                                                                         if c is OTHER else c[0]
                                                                         for c in competitors),
                prepare=lay_other)
    race.competitors = competitors
    return race
