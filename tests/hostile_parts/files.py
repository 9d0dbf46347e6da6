"""Attacks on the files of a flight: damaged, replaced, or in folders with strange names."""

import os

from . import instead, raw, rows, strips
from .cases import ALL, CALIBRATE, CHECK, GAUSS_HELMERT, GEOREF, MATCH, SMOOTH, Case
from .flights import text_trajectory
from .program import Conditions
from .values import TOUCH, short

FILES = {
    "IMU.txt": (CALIBRATE, CALIBRATE, SMOOTH, CHECK),
    "GPS.txt": (CALIBRATE, CALIBRATE, SMOOTH, CHECK),
    "lidar/1_2.txt": (CALIBRATE, CALIBRATE, CALIBRATE, GAUSS_HELMERT, CHECK),
    "surfaces/1_2.txt": (CALIBRATE, CALIBRATE, CHECK),
    "lidar_b/1_2.txt": (CALIBRATE, CALIBRATE, CHECK),
    "control/points.txt": (CALIBRATE, CHECK),
    "control/checks.txt": (CALIBRATE, CHECK),
    "trajectory.out": (GAUSS_HELMERT, GAUSS_HELMERT, ALL),
    "trajectory.txt": (GAUSS_HELMERT,),
    "trajectory_sigma.txt": (GAUSS_HELMERT,),
    "trajectory_covariance.txt": (GAUSS_HELMERT,),
    "initial_guess.out": (CALIBRATE, SMOOTH),
    "initial_guess.txt": (CALIBRATE, SMOOTH),
    "reference.out": (CALIBRATE, SMOOTH),
    "reference.txt": (CALIBRATE,),
    "strips/1.las": (GEOREF, MATCH, CHECK),
    "strips/2.txt": (GEOREF, MATCH),
    "flight.yaml": (CALIBRATE, CHECK),
    "truth.yaml": (CALIBRATE,),
}
STRANGE_NAMES = [
    "a b", "a'b", 'a"b', "a;b", "a\nb", "a\tb", "-rf", "--out", "ü漢🛩", "a\\b", "%s%n", "x" * 250,
    "a\x1b[2Jb", "a\x07b", f"$({TOUCH})", f"`{TOUCH}`", f"a\n!{TOUCH}\nb", f"'; {TOUCH}; '",
    f'"; {TOUCH}; "', "*", "?", "~", "#", "a:b", "\udcff", "flight.yaml", "[a]", "{a,b}", "&", "|",
    "...", f"a\nsystem('{TOUCH}')\nb"]


def lay(arena, name):
    """Writes an undamaged file. If the flight lacks it, it is made from the trajectory."""
    path = arena.flight / name
    if name.startswith("lidar_b"):
        arena.write("flight.yaml", arena.base.yaml_two)
    sbet = arena.flight / "trajectory.out"
    if not path.exists():
        content = sbet.read_bytes()
        arena.write(name, text_trajectory(content) if name.endswith(".txt") else content)
    if name == "trajectory.txt":
        sbet.unlink()
        yaml = (arena.flight / "flight.yaml").read_text().replace("trajectory.out", name)
        arena.write("flight.yaml", yaml)
    if name == "reference.txt":
        (arena.flight / "reference.out").unlink()
    return path


def damage(rng, arena, name):
    """Damages the file. Returns a description of the damage."""
    path = lay(arena, name)
    draw = rng.random()
    if draw < 0.1 and name != "truth.yaml":
        return instead.laid(rng, path)
    change = raw.damaged
    if name.endswith(".out") and draw < 0.6:
        change = raw.damaged_sbet
    if name.endswith(".las") and draw < 0.75:
        change = strips.damaged_las
    if name.endswith(".txt") and draw < 0.75:
        change = rows.damaged
    content, how = change(rng, path.read_bytes())
    arena.write(name, content)
    return how


def file_case(rng, number):
    name = list(FILES)[number % len(FILES)]
    case = Case(name, rng.choice(FILES[name]))

    def prepare(arena):
        how = damage(rng, arena, name)
        case.label = f"{name}: {how}"
        case.conditions = Conditions(as_nobody=how == "unreadable")

    case.prepare = prepare
    return case


def flight_named(rng, name):
    """Gives the folder of the flight, and in some cases the flight itself, a strange name."""
    nameless = rng.random() < 0.5

    def prepare(arena):
        target = arena.here / name
        os.rename(arena.flight, target)
        arena.flight = target
        if nameless:
            config = target / "flight.yaml"
            config.write_text(config.read_text().replace("name: small\n", ""))

    return prepare


def name_case(rng):
    name = rng.choice(STRANGE_NAMES)
    command = rng.choice(["calibrate", "smooth", "check"])
    if rng.random() < 0.6:
        return Case(f"{command}, flight in a folder named {short(name)}",
                    [command, "./" + name, "--out", "out"], flight_named(rng, name), echoes=name)

    def prepare(arena):
        arena.out = arena.here / name

    return Case(f"{command}, results in a folder named {short(name)}",
                [command, "flight", "--out", "./" + name], prepare, echoes=name, anywhere=True)


def case(base, rng, number):
    return name_case(rng) if rng.random() < 0.06 else file_case(rng, number)
