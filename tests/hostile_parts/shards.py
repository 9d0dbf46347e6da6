"""Shards of a series of others, merged or taken up: what is refused, and never a wrong sum."""

import hashlib
import json
import shutil

from . import instead, trees
from .cases import Case
from .program import Conditions

PEAK_MB = 1000.0
SILENT = Conditions(environment={"PATH": "/nonexistent"})  # without gnuplot
FLIGHTS = 4
SEED = 3
MONTE_CARLO = ["monte-carlo", "small.yaml", "--flights", str(FLIGHTS), "--seed", str(SEED), "--epoch-spacing", "20",
               "--threads", "1"]
STUDY = ["study", "--sweep", "sweep.yaml", "--threads", "1"]
SWEEP = "base: small.yaml\nsweep:\n  gnss.rate_hz: [1, 2]\n  pairs.count: {few: 40, many: 60}\n"


class Kind:
    """A series: how it is flown, and where its records lie."""

    def __init__(self, name, command, records, numbers, result):
        self.name, self.command, self.records, self.numbers, self.result = name, command, records, numbers, result

    def record(self, number):
        return f"{self.records}/{number:06d}.json"


KINDS = [Kind("series", MONTE_CARLO, "flights", list(range(SEED, SEED + FLIGHTS)), "monte_carlo.json"),
         Kind("sweep", STUDY, "designs", [1, 2, 3, 4], "sweep.json")]


def lay_inputs(base, folder):
    (folder / "small.yaml").write_text(base.scenario)
    (folder / "sweep.yaml").write_text(SWEEP)


def make(base, run):
    """The results that are attacked: whole series and their shards."""
    lay_inputs(base, base.flight.parent / "here")
    for kind in KINDS:
        run(*kind.command, "--out", base.results / kind.name)
        for shard in ("1", "2"):
            run(*kind.command, "--shard", shard + "/2", "--out", base.results / (kind.name + shard))


def set_value(path, *keys, value):
    tree = json.loads(path.read_bytes())
    inside = tree
    for key in keys[:-1]:
        inside = inside[key]
    inside[keys[-1]] = value
    path.write_text(json.dumps(tree))


def other_record(rng, folder, kind, here):
    """The record of another number under this one's name."""
    other = rng.choice([n for n in kind.numbers if n != here])
    for source in (folder, folder.parent / "two"):
        if (source / kind.record(other)).exists():
            shutil.copy(source / kind.record(other), folder / kind.record(here))
            return f"record {here} is that of {other}"
    return ""


def other_number(rng, folder, kind, here):
    key = "seed" if kind.name == "series" else "number"
    value = rng.choice([0, 1, 2, here + 1, here - 1, here + 2, 2 ** 64 - 1, -1, str(here), here + 0.5, None])
    if value == here:
        return ""
    set_value(folder / kind.record(here), key, value=value)
    return f"{key} of {here} is {value}"


def other_origin(rng, folder, kind, here):
    set_value(folder / kind.record(here), "made_from", value=rng.choice(["", "0" * 64, None, 7, "x" * 20000]))
    return f"record {here} was made from something else"


def other_series(rng, folder, kind, here):
    key, value = rng.choice([("flights", 1000000000000), ("flights", 10 ** 18), ("flights", 1e18), ("flights", 0),
                             ("flights", 3), ("flights", 5), ("flights", 999999), ("first", 1 + here), ("first", -1),
                             ("first", 2 ** 64 - 1), ("shard", "1/1"), ("shard", "0/0"), ("shard", "2/1"),
                             ("shard", "1/999999"), ("command", "match"), ("command", ""), ("made_from", "0" * 64)])
    set_value(folder / "report.json", "series", key, value=value)
    return f"series {key} {value}"


def other_build(rng, folder, kind, here):
    key = rng.choice(["program", "version", "scenario" if kind.name == "series" else "sweep"])
    set_value(folder / kind.records / "made_from.json", key, value=rng.choice(["", "x", "0" * 64, None, [], 1e308]))
    return f"made_from {key}"


RANGES = {"series": ["redundancy", "outliers", "chi2", "check_p_value", "time_s", "boresight_covariance_rad2",
                     "epochs", "residuals", "position_rms_m"],
          "sweep": ["labels", "sigma_rad", "condition_number", "correlation_angles", "position_m"]}
BEYOND = [1e308, -1e308, 10 ** 30, -1, "1", True, None, {}, [[]], [1, 2], [[1]], ["a", "b"], 2 ** 63]


def beyond_range(rng, folder, kind, here):
    key = rng.choice(RANGES[kind.name])
    value = rng.choice(BEYOND)
    set_value(folder / kind.record(here), key, value=value)
    return f"{key} of {here} is {json.dumps(value)}"


def lost_record(rng, folder, kind, here):
    (folder / kind.record(here)).unlink()
    return f"record {here} is lost"


def special(rng, folder, kind, here):
    """Something else lies where a file should be; a link to a good file would be one."""
    name = rng.choice(["report.json", kind.records + "/made_from.json", kind.record(here)])
    return f"{name} is {instead.laid(rng, folder / name)}"


def any_damage(rng, folder, kind, here):
    name = rng.choice(["report.json", kind.records + "/made_from.json", kind.record(here), kind.record(here)])
    return f"{name} {trees.damage(rng, folder / name)}"


# Whether a merge of what is so changed can be right.
WRONG = [other_record, other_number, other_origin, other_series, other_build, beyond_range, beyond_range, lost_record,
         special]


def numbers_of(folder, kind):
    """The numbers in the records of a result, in the order of their names."""
    key = "seed" if kind.name == "series" else "number"
    return [json.loads(path.read_bytes())[key] for path in sorted((folder / kind.records).glob("0*.json"))]


def digest(path):
    return hashlib.blake2b(path.read_bytes()).hexdigest()


class Shards(Case):
    """A run that succeeds has every record once; with changes that are wrong it does not succeed."""

    def attack(self, arena):
        outcome, findings = super().attack(arena)
        if outcome.exit_code == 0:
            findings += self.judge_sum(arena)
        return outcome, findings

    def judge_sum(self, arena):
        try:
            numbers = numbers_of(arena.out, self.kind)
        except ValueError as error:
            return [("wrong merge", f"a record that is not JSON was taken: {error}")]
        if numbers != self.kind.numbers:
            return [("wrong merge", f"records of {numbers}")]
        same = digest(arena.out / self.kind.result) == digest(arena.base.results / self.kind.name / self.kind.result)
        if self.must_fail and not same:
            return [("wrong merge", "the sum is another one")]
        if self.must_fail and not self.may_be_flown_again:
            return [("wrong merge", "what is wrong was not refused")]
        return []


def case(base, rng, number):
    kind = KINDS[number % 2]
    resume = rng.random() < 0.35
    change = any_damage if rng.random() < 0.4 else rng.choice(WRONG)
    if resume and change is other_series:
        change = beyond_range
    words = [*kind.command, "--out", "out"] if resume else ["merge", "one", "two", "--out", "out"]
    shards = Shards("", words, conditions=SILENT, peak_mb=PEAK_MB)
    shards.kind = kind
    shards.must_fail = change is not any_damage
    # A series that is taken up flies what is missing, and writes its report again.
    shards.may_be_flown_again = resume and change in (lost_record, special)

    def prepare(arena):
        lay_inputs(base, arena.here)
        folder = arena.here / "one"
        for name, shard in (("one", kind.name + "1"), ("two", kind.name + "2")):
            shutil.copytree(base.results / shard, arena.here / name)
        if resume:
            folder = arena.out
            shutil.copytree(base.results / kind.name, folder)
        here = rng.choice(kind.numbers if resume else kind.numbers[::2])
        how = change(rng, folder, kind, here)
        shards.must_fail = shards.must_fail and how != ""  # nothing was changed
        shards.conditions = Conditions(environment=SILENT.environment, as_nobody="unreadable" in how)
        shards.label = f"{words[0]} of a {kind.name}: {how}"

    shards.prepare = prepare
    return shards
