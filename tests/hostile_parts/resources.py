"""Runs with too little memory, disk, streams or threads, or in a strange environment."""

import os
import resource
import subprocess

from .cases import ALL, CALIBRATE, CHECK, GAUSS_HELMERT, SMOOTH, Case
from .judge import judge
from .program import Conditions
from .signals import half_written, lay_scenario, run_again
from .values import TOUCH, short

SIMULATE = ["simulate", "scenario.yaml", "--out", "out"]
COMMANDS = [CALIBRATE, CALIBRATE, SMOOTH, GAUSS_HELMERT, ALL, SIMULATE, CHECK]
MB = 1 << 20


def after_failure(arguments, as_nobody=False):
    """Checks that no file is half written and that the next run, without the shortage, works."""
    def judge_after(arena, outcome):
        findings = [("half written", name) for name in half_written(arena.out)]
        if outcome.exit_code not in (0, None):
            findings += run_again(arena, arguments, as_nobody)
        return findings
    return judge_after


def memory(rng, command):
    limit = rng.choice([100, 150, 200, 250, 300, 400, 500, 600, 800])
    threads = rng.choice([[], ["--threads", "1"], ["--threads", "2"], ["--threads", "64"]])
    return Case(f"{command[0]} {' '.join(threads)} with {limit} MB of address space",
                [*command, *threads], lay_scenario,
                Conditions(limits={resource.RLIMIT_AS: limit * MB}), after=after_failure(command))


def file_size(rng, command):
    limit = rng.choice([0, 1, 100, 1000, 10000, 70000, 100000, 500000])
    return Case(f"{command[0]} with files of {limit} bytes at most", command, lay_scenario,
                Conditions(limits={resource.RLIMIT_FSIZE: limit}), heard=limit > 5000,
                after=after_failure(command))


def threads(rng, command):
    limit = rng.choice([0, 1, 2, 3])
    return Case(f"{command[0]} with {limit} threads more at most", [*command, "--threads", "4"],
                lay_scenario,
                Conditions(limits={resource.RLIMIT_NPROC: limit}, as_nobody=True),
                after=after_failure(command, as_nobody=True))


def descriptors(rng, command):
    limit = rng.choice([4, 5, 6, 8, 16])
    return Case(f"{command[0]} with {limit} open files at most", command, lay_scenario,
                Conditions(limits={resource.RLIMIT_NOFILE: limit}), after=after_failure(command))


def closed_streams(rng, command):
    closed = rng.choice([(0,), (1,), (2,), (0, 1), (1, 2), (0, 1, 2)])
    return Case(f"{command[0]} with streams {closed} closed", command, lay_scenario,
                Conditions(closed=closed),
                heard=2 not in closed, after=after_failure(command))


def full_streams(rng, command):
    full = rng.choice(["stdout", "stderr", "both"])
    conditions = Conditions(stdout="/dev/full" if full != "stderr" else None,
                            stderr="/dev/full" if full != "stdout" else None)
    return Case(f"{command[0]} with {full} full", command, lay_scenario, conditions,
                heard=full == "stdout",
                after=after_failure(command))


ENVIRONMENTS = [
    ("TMPDIR", None), ("TMPDIR", ""), ("TMPDIR", "/nowhere"), ("TMPDIR", f"/tmp'; {TOUCH}; '"),
    ("TMPDIR", f"$({TOUCH})"),
    ("TMPDIR", f"/tmp\n!{TOUCH}\n"), ("TMPDIR", "/dev/null"), ("HOME", None), ("HOME", "/nowhere"),
    ("HOME", f"$({TOUCH})"), ("PATH", ""),
    ("PATH", None), ("PATH", "/nowhere"), ("LC_ALL", "de_DE.UTF-8"), ("LC_ALL", "tr_TR.UTF-8"),
    ("LC_ALL", "nonsense"), ("LANG", "\udcff"),
    ("OMP_NUM_THREADS", "0"), ("OMP_NUM_THREADS", "-5"), ("OMP_NUM_THREADS", "x"),
    ("OMP_NUM_THREADS", "100000"),
    ("OPENBLAS_NUM_THREADS", "1000"), ("GNUTERM", "dumb"), ("GNUPLOT_LIB", f"`{TOUCH}`"),
    ("GNUPLOT_DRIVER_DIR", "/nowhere"),
    ("TERM", None), ("TERM", "x" * 10000), ("COLUMNS", "-1"), ("MALLOC_PERTURB_", "165"),
    ("TZ", "../../etc/passwd")]


def environment(rng, command):
    name, value = rng.choice(ENVIRONMENTS)
    return Case(f"{command[0]} with {name}={short(value) if value is not None else 'nothing'}",
                command, lay_scenario,
                Conditions(environment={name: value}), after=after_failure(command))


class Mounted(Case):
    """Writes the results to a file system that is too small for them."""

    def attack(self, arena):
        self.prepare(arena)
        arena.out.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={self.size_kb}k", "none",
                                  arena.out],
                                 capture_output=True, check=False).returncode == 0
        try:
            arena.remember()
            self.conditions.limits = {} if mounted else {resource.RLIMIT_FSIZE: self.size_kb * 1024}
            outcome = arena.base.program.run(self.arguments, arena.folder, self.conditions)
            findings = [("half written", name) for name in half_written(arena.out)]
            return outcome, findings + judge(outcome, arena)
        finally:
            if mounted:
                subprocess.run(["umount", arena.out], check=False)


def full_disk(rng, command):
    size_kb = rng.choice([4, 8, 40, 100, 400, 700, 1000])
    case = Mounted(f"{command[0]} onto a disk of {size_kb} kB", command, lay_scenario)
    case.size_kb = size_kb
    return case


def locked_folder(rng, command):
    what = rng.choice(["out is read-only", "out is a file", "out is a link to nothing",
                       "out is a link to the flight",
                       "flight is read-only", "out is the flight", "out is inside the flight",
                       "out holds a flight",
                       "out is a FIFO", "a folder stands where result.json goes"])
    words = list(command)
    if what == "out is the flight":
        words[words.index("out")] = "flight"
    if what == "out is inside the flight":
        words[words.index("out")] = "flight/lidar"

    def prepare(arena):
        lay_scenario(arena)
        if what == "out is read-only":
            arena.out.mkdir(mode=0o555)
        elif what == "out is a file":
            arena.out.write_text("mine\n")
        elif what == "out is a link to nothing":
            arena.out.symlink_to("nowhere")
        elif what == "out is a link to the flight":
            arena.out.symlink_to("flight")
        elif what == "flight is read-only":
            arena.flight.chmod(0o555)
        elif what == "out holds a flight":
            arena.out.mkdir()
            for name in ("flight.yaml", "IMU.txt", "trajectory.out"):
                (arena.out / name).write_text("mine\n")
        elif what == "out is a FIFO":
            os.mkfifo(arena.out)
        elif what == "a folder stands where result.json goes":
            (arena.out / "result.json" / "mine").mkdir(parents=True)

    def untouched(arena, outcome):
        if what != "out holds a flight":
            return []
        lost = [name for name in ("flight.yaml", "IMU.txt", "trajectory.out")
                if not (arena.out / name).exists() or (arena.out / name).read_text() != "mine\n"]
        return [("input changed", f"out/{name}, which no run had written") for name in lost]

    return Case(f"{command[0]}: {what}", words, prepare, Conditions(as_nobody=True),
                anywhere="inside" in what or "nothing" in what,
                after=untouched)


KINDS = [memory, memory, file_size, full_disk, threads, descriptors, closed_streams, full_streams,
         environment, environment,
         locked_folder, locked_folder]


def case(base, rng, number):
    kind = KINDS[number % len(KINDS)]
    return kind(rng, rng.choice(COMMANDS))
