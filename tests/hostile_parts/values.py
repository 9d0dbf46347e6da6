"""Replaces values of flight.yaml, of a scenario and of the command line by hostile ones."""

import json
import re
import signal

from .arena import CANARY, read_truth
from .cases import CALIBRATE, CHECK, GAUSS_HELMERT, SMOOTH, Case
from .judge import judge_end, judge_result
from .program import Conditions

TOUCH = f"touch {CANARY}"
NUMBERS = [
    "nan", ".nan", ".NaN", "inf", ".inf", "-.inf", "-inf", "1e999", "-1e999", "1e308", "-1e308",
    "1e-308", "5e-324", "0", "-0.0", "-1", "1", "2", "1e20", "-1e20", "1e12", "1e6", "1e-12",
    "9007199254740993", "18446744073709551616", "2147483648", "-2147483649", "9" * 400,
    "0." + "1" * 400,
    "1,5", "1;2", "1 000", "1e", "--1", "+", "0x1f", "1_000", "0o17", "1e3e3", "3.14.15", "١٢٣",
    "381000", "604800", "-604801", "90", "180", "360", "1000", "0.001"]
TEXTS = [
    "~", "''", '""', '" "', "yes", "true", "text", "None", "odyn", "2026-11-21", ".", "..", "/",
    "/dev/zero",
    "/dev/stdin", "/dev/full", "/proc/self/mem", "/etc/passwd", "../../../../etc/passwd", "~/x",
    "'*'",
    '"%s%n%d"', '"' + "x" * 300 + '"', '"' + "y" * 100000 + '"', '"ü漢🛩"', '"\\u202e"', '"\\0"',
    '"\\e[2J"',
    '"\\x07"', '"a\\tb"', '"a\\rb"', '"-rf"', '"--out"', '"a,b"', '"a\'b"', '"#"', '"a: b"',
    '"file\\\\name"',
    f'"$({TOUCH})"', f'"`{TOUCH}`"', f'"; {TOUCH}; "', f'"| {TOUCH}"', f'"\' ; {TOUCH} ; \'"',
    f'"&& {TOUCH}"',
    f'"\\n!{TOUCH}\\n"', f'"a\\nsystem(\\"{TOUCH}\\")\\n"', f'"\\"; system \\"{TOUCH}\\" #"']
SHAPES = [
    "[]", "{}", "[[]]", "[1]", "[1, 2]", "[1, 2, 3, 4]", "[nan, nan, nan]", "[0, 0, 0]",
    "[1e308, 1e308, 1e308]",
    "[a, b, c]", "{a: 1}", "[[1, 0, 0], [0, 1, 0], [0, 0, -1]]", "[[1, 0, 0], [0, 1, 0]]",
    "[[2, 0, 0], [0, 2, 0], [0, 0, 2]]", "[[0, 0, 0], [0, 0, 0], [0, 0, 0]]", "[~, ~, ~]",
    "[1, [2], 3]",
    "[100, 0]", "[381000, 381000]", "[381300, 381000]", "[-90.1, 0, 0]", "[90, 0, 0]",
    "[0, 181, 0]",
    "[1e-300, 1e-300, 1e-300]", "[-1, -1, -1]", "[1000, 1000, 1000]", "[" + "1, " * 5000 + "1]",
    "[" * 200 + "]" * 200, "[" * 20000 + "]" * 20000, "{" * 5000 + "}" * 5000, "&a [*a]", "*x",
    "!!binary aGk=",
    "!!python/object:os.system x", "|", ">", "? x", "[1, 2", "{a: [}", "\t1", "- 1", "@", "%", "'",
    '"', "&", "*",
    "1 # 2", "{<<: 1}"]
ALL = NUMBERS + TEXTS + SHAPES

# Matches a key and its value. A value that begins with `{` or `[` contains further values.
LINE = re.compile(r"^(?P<head>\s*(?:- )?(?P<key>\w+):(?: |$))(?P<value>.*)$")
INNER = re.compile(r"[^\s\[\]{},:\"]+")


def spots(text):
    """Returns (line, begin, end) of every value, every part of a value and every key."""
    found = []
    for number, line in enumerate(text.splitlines()):
        match = LINE.match(line)
        if match and match.group("value"):
            found.append((number, match.start("value"), match.end("value")))
        if match:
            found.append((number, match.start("key"), match.end("key")))
        begin = match.start("value") if match else 0
        if "{" in line or "[" in line:
            found += [(number, begin + m.start(), begin + m.end())
                      for m in INNER.finditer(line[begin:])]
    return found


def replaced(text, spot, value):
    number, begin, end = spot
    lines = text.splitlines()
    lines[number] = lines[number][:begin] + value + lines[number][end:]
    return "\n".join(lines) + "\n"


def delete(rng, lines, at):
    del lines[at]


def double(rng, lines, at):
    lines.insert(at, lines[at])


def swap(rng, lines, at):
    other = rng.randrange(len(lines))
    lines[at], lines[other] = lines[other], lines[at]


def indent(rng, lines, at):
    lines[at] = "   " + lines[at]


def outdent(rng, lines, at):
    lines[at] = lines[at].lstrip()


def tab(rng, lines, at):
    lines[at] = "\t" + lines[at]


def cut(rng, lines, at):
    lines[at:] = [lines[at][:rng.randrange(len(lines[at]) + 1)]]


def join(rng, lines, at):
    lines[at:at + 2] = ["".join(lines[at:at + 2])]


def lose_section(rng, lines, at):
    tops = [i for i, line in enumerate(lines) if line[:1].strip()]
    first = rng.choice(tops)
    after = [i for i in tops if i > first] + [len(lines)]
    del lines[first:after[0]]


def carriage_returns(rng, lines, at):
    lines[:] = [line + "\r" for line in lines]


def byte_order_mark(rng, lines, at):
    lines[0] = "\ufeff" + lines[0]


STRUCTURE = [delete, double, swap, indent, outdent, tab, cut, join, lose_section, carriage_returns,
             byte_order_mark]


def restructured(text, rng):
    """Removes, doubles, moves or indents lines."""
    lines = text.splitlines()
    at = rng.randrange(len(lines))
    change = rng.choice(STRUCTURE)
    change(rng, lines, at)
    return "\n".join(lines) + "\n", f"{change.__name__} at line {at + 1}"


def short(value):
    return json.dumps(value if len(value) < 40 else value[:20] + f"... {len(value)} characters",
                      ensure_ascii=True)


def varied(text, rng, number):
    """Returns a variant of a YAML text with its label, the new value and whether it has a place."""
    if rng.random() < 0.12:
        changed, label = restructured(text, rng)
        return changed, label, "", False
    places = spots(text)
    spot = places[number % len(places)]
    value = rng.choice(ALL)
    line = text.splitlines()[spot[0]]
    label = f"{line.strip()[:40]!r}: {line[spot[1]:spot[2]][:20]} -> {short(value)}"
    return replaced(text, spot, value), label, value, True


TWO_SCANNERS = 0.2  # share of the attacks on a list of two scanners


def flight_case(base, rng, number):
    two = rng.random() < TWO_SCANNERS
    text, label, value, place = varied(base.yaml_two if two else base.yaml, rng, number)
    command = CALIBRATE
    draw = 1.0 if two else rng.random()
    if "trajectory" in label or "sigma_" in label and draw < 0.3 or draw < 0.15:
        command = GAUSS_HELMERT
    elif draw < 0.25:
        command = rng.choice([CHECK, SMOOTH])
    return Case(f"flight.yaml {label}", command, lambda arena: arena.write("flight.yaml", text),
                needs_location=place, echoes=value)


# A scenario may require hours of flight. This does not count as a hang if a signal ends the run.
LONG_FLIGHT_MB = 2000.0
PATIENCE = Conditions(signals=((10.0, signal.SIGINT),), time_limit_s=15.0)


def scenario_case(base, rng, number):
    two = rng.random() < TWO_SCANNERS
    text, label, value, place = varied(base.scenario_two if two else base.scenario, rng, number)

    def prepare(arena):
        (arena.here / "scenario.yaml").write_text(text)

    def calibrate(arena, outcome):
        if outcome.exit_code != 0:
            return []
        arena.truth_deg = read_truth(arena.out)
        calibration = Case(label, ["calibrate", "out", "--out", "result"])
        arena.remember()
        again = arena.base.program.run(calibration.arguments, arena.folder, PATIENCE)
        arena.out = arena.here / "result"
        return judge_end(again, arena, LONG_FLIGHT_MB) + judge_result(again, arena)

    seed = str(rng.randrange(1000))
    return Case(f"scenario {label}", ["simulate", "scenario.yaml", "--seed", seed, "--out", "out"],
                prepare,
                PATIENCE, needs_location=place, echoes=value, peak_mb=LONG_FLIGHT_MB,
                after=calibrate)


PHYSICS = """\
physics:
  - {name: ripple, adds_to: lidar_forward_deg, size: 0.01, shape: sine, of: scan_angle_deg, period: [4, 12]}
  - {name: warming, adds_to: accelerometer_mgal, size: 20, shape: decay, of: time_s, tau: [60, 300]}
  - name: saw
    adds_to: boresight_deg
    size: 0.01
    shape: linear
    of: heading_deg
    over: [0, 360]
  - {name: late, adds_to: lidar_clock_s, size: 1e-4, shape: walk}
  - {name: strips, adds_to: lidar_range_m, size: 0.02, shape: per_strip}
"""


def physics_case(base, rng, number):
    text, label, value, place = varied(PHYSICS, rng, number)

    def prepare(arena):
        (arena.here / "physics.yaml").write_text(text)

    return Case(f"physics {label}",
                ["blind-check", "--only", "outsider", "--physics", "physics.yaml", "--flights", "1",
                 "--gap-options", "screen", "--seed", str(rng.randrange(1000)), "--threads", "1",
                 "--scenarios", "leg2_rest", "--out", "out"],
                prepare, PATIENCE, needs_location=place, echoes=value, peak_mb=LONG_FLIGHT_MB)


OPTION_VALUES = ["", " ", "nan", "-1", "0", "1e9", "99999999999999999999", "1.5", "x", "--out", "-",
                 "--", "/dev/null",
                 "/dev/full", "/proc/x", ".", "..", "flight", "flight/x", "here/none/none", "out\n",
                 "out\x1b[2J", "ü漢",
                 "x" * 300, "y" * 5000, f"$({TOUCH})", f"`{TOUCH}`", f"\n!{TOUCH}\n",
                 f"a'; {TOUCH}; '", "flight/IMU.txt",
                 "flight/flight.yaml", "%s%n", "~", "*", "\\", "\"", "'"]
COMMANDS = {
    "calibrate": ["flight", "--out", "out", "--method", "dn", "--threads", "1"],
    "smooth": ["flight", "--out", "out", "--threads", "1"],
    "init": ["flight", "--out", "out"],
    "check": ["flight", "--out", "out"],
    "georef": ["flight", "--boresight", "0.1,0.2,0.3", "--trajectory", "flight/trajectory.out",
               "--covariance", "--sigma-range-m", "0.02", "--out", "out"],
    "simulate": ["lar3.yaml", "--out", "out", "--seed", "1", "--threads", "1"],
    "allan": ["flight/IMU.txt", "--rate", "25", "--format", "odyn", "--body", "FRD", "--out",
              "out"],
    "monte-carlo": ["lar3.yaml", "--flights", "1", "--seed", "1", "--epoch-spacing", "1", "--out",
                    "out"],
}


def option_case(base, rng, number):
    command = sorted(COMMANDS)[number % len(COMMANDS)]
    words = list(COMMANDS[command])
    value = rng.choice(OPTION_VALUES)
    at = rng.randrange(len(words))
    change = rng.choice(["value", "value", "value", "drop", "double", "swap", "insert"])
    if change == "value":
        words[at] = value
    elif change == "drop":
        del words[at]
    elif change == "double":
        words.insert(at, words[at])
    elif change == "swap":
        other = rng.randrange(len(words))
        words[at], words[other] = words[other], words[at]
    else:
        words.insert(at, value)
    words = [word.replace("\0", "") for word in words]

    def prepare(arena):
        (arena.here / "lar3.yaml").write_text(base.scenario)

    return Case(f"options {command} " + " ".join(short(w) for w in words), [command, *words],
                prepare,
                echoes=value, anywhere=True)


def case(base, rng, number):
    draw = rng.random()
    if draw < 0.57:
        return flight_case(base, rng, number)
    if draw < 0.6:
        return physics_case(base, rng, number)
    return scenario_case(base, rng, number) if draw < 0.85 else option_case(base, rng, number)
