"""Results folders of others: where results are written, and where they are read."""

import os
import shutil

from . import instead, trees
from .cases import CALIBRATE, CHECK, SMOOTH, Case
from .program import Conditions

PEAK_MB = 1000.0
WRITERS = [CHECK, CHECK, CHECK, SMOOTH, CALIBRATE]
STAGING = ".dn-staging-abcdef"
# These must stay untouched; `victim` is a file next to the results folder.
OUTSIDE = ["../victim", "../elsewhere/1_2.txt", "/victim", "..", ".", "../..", "../out/../victim", "a/../../victim",
           "a/b/../../../victim", "{here}/victim", "/etc/hostname", "", "lidar/../../victim", "./../victim",
           "flight/../victim", "../flight/IMU.txt", "../flight/flight.yaml"]
INSIDE = ["result.json", "report.json", "lidar/1_2.txt", "plots/a.svg", ".hidden", "notes.txt", "a\x1bb", "a" * 300]


def lay_outside(arena):
    (arena.here / "victim").write_text("of the user")
    (arena.here / "elsewhere").mkdir()
    for name in ("1_2.txt", "victim", "report.json", "result.json", "000001.json"):
        (arena.here / "elsewhere" / name).write_text("of the user")


def names(rng, arena):
    chosen = [rng.choice(OUTSIDE if rng.random() < 0.7 else INSIDE) for _ in range(rng.randrange(1, 6))]
    return [name.replace("{here}", str(arena.here)) for name in chosen]


def first_line(rng, arena, staging):
    """The line that a run would write there, or one of another place."""
    draw = rng.random()
    if draw < 0.5:
        return f"dn.commit/1 {arena.out.stat().st_ino} {staging.stat().st_ino}\n"
    return rng.choice(["", "dn.commit/1\n", "dn.commit/1 1 2\n", "\n", "dn.commit/2 0 0\n",
                       f"dn.commit/1 {staging.stat().st_ino} {arena.out.stat().st_ino}\n"])


def lay_journal(rng, arena):
    """A folder that looks as if a run had been killed while it published."""
    staging = arena.out / STAGING
    kept = staging / ".replaced"
    kept.mkdir(parents=True)
    (arena.out / "result.json").write_text("of the user")
    chosen = names(rng, arena)
    for name in ("victim", "result.json", "notes.txt"):
        for folder in (staging, kept):
            if rng.random() < 0.5:
                (folder / name).write_text("evil")
    for base in (arena.out, staging, kept):
        for name in ("lidar", "plots", "a", "elsewhere"):
            if rng.random() < 0.3:
                (base / name).symlink_to(arena.here / "elsewhere")
    journal = staging / ".commit"
    how = "journal"
    if rng.random() < 0.25:
        how = "journal: " + instead.laid(rng, journal)
    else:
        text = first_line(rng, arena, staging) + "".join(name + "\n" for name in chosen)
        journal.write_bytes(text.encode() * rng.choice([1, 1, 1, 20000]))
        how += f" of {chosen}"[:200]
    draw = rng.random()
    if draw < 0.15:
        shutil.rmtree(kept)
        kept.symlink_to(rng.choice([arena.here, arena.here / "elsewhere", "/", ".", "nowhere"]))
    elif draw < 0.3:
        os.rename(staging, arena.here / "staged")
        staging.symlink_to(arena.here / "staged")
        how += ", the staging folder is a link"
    return how


def lay_report(rng, arena):
    """report.json of an earlier run, and perhaps what it names."""
    path = arena.out / "report.json"
    listed = names(rng, arena)
    path.write_bytes(trees.json.dumps({"schema": "dn.report/1", "command": "smooth", "error": None,
                                       "files": listed}).encode())
    for name in ("lidar", "plots", "a"):
        if rng.random() < 0.4:
            (arena.out / name).symlink_to(arena.here / "elsewhere")
    if rng.random() < 0.3:
        return f"report.json lists {listed}"[:200]
    return "report.json " + trees.damage(rng, path)


def lay_links(rng, arena):
    """Names of the results that are links, folders or devices."""
    laid = []
    for name in rng.sample(["report.json", "report.html", "result.json", "smooth.json", "trajectory.out",
                            "config.resolved.yaml", "smooth.json", "trajectory.svg"], 3):
        path = arena.out / name
        if path.is_symlink() or path.exists():
            continue
        if rng.random() < 0.6:
            path.symlink_to(rng.choice(["../victim", "../elsewhere/report.json", "../elsewhere", "nowhere", "/dev/zero"]))
            laid.append(f"{name} is a link")
        else:
            laid.append(f"{name} is {instead.laid(rng, path)}")
    return ", ".join(laid)


def write_case(base, rng, number):
    """Results are written into a folder of somebody else."""
    command = rng.choice(WRITERS)
    lay = [lay_journal, lay_report, lay_links][number % 3]
    case = Case("", [*command, "--threads", "1"], peak_mb=PEAK_MB,
                conditions=Conditions(environment={"PATH": "/nonexistent"}))

    def prepare(arena):
        lay_outside(arena)
        arena.out.mkdir()
        case.label = f"{command[0]} into a folder where {lay(rng, arena)}"

    case.prepare = prepare
    return case


JSON_FILES = {"smoothed": ["report.json", "smooth.json", "smooth.json"],
              "calibrated": ["report.json", "result.json", "result.json", "result.json", "swaths.json"],
              "series": ["report.json", "monte_carlo.json"],
              "sweep": ["report.json", "sweep.json", "sweep.json"]}


def report_case(base, rng, number):
    """A page is made from damaged results."""
    kind = list(JSON_FILES)[number % len(JSON_FILES)]
    name = rng.choice(JSON_FILES[kind])
    folders = ["result"] if rng.random() < 0.8 else ["result", "other"]
    case = Case("", ["report", *folders, "--out", "page.html"], peak_mb=PEAK_MB, anywhere=True)

    def prepare(arena):
        for folder in folders:
            shutil.copytree(base.results / kind, arena.here / folder)
        how = trees.damage(rng, arena.here / "result" / name)
        case.conditions = Conditions(as_nobody=how == "unreadable")
        case.label = f"report of {kind}, {name} {how}"

    case.prepare = prepare
    return case


def georef_case(base, rng, number):
    """A result is given to georef."""
    case = Case("", ["georef", "flight", "--result", "result.json", "--covariance", "--threads", "1", "--out", "out"],
                peak_mb=PEAK_MB)

    def prepare(arena):
        shutil.copy(base.results / "calibrated" / "result.json", arena.here / "result.json")
        how = trees.damage(rng, arena.here / "result.json")
        case.conditions = Conditions(as_nobody=how == "unreadable")
        case.label = f"georef --result {how}"

    case.prepare = prepare
    return case


def case(base, rng, number):
    draw = rng.random()
    if draw < 0.45:
        return write_case(base, rng, number)
    return report_case(base, rng, number) if draw < 0.8 else georef_case(base, rng, number)
