"""Numbers, lists and files that ask for time or memory without end, and texts for a terminal."""

import os
import shutil
import struct

from .cases import Case
from .values import short

SECONDS = 5.0  # from the start to a refusal, on a busy machine
LITTLE_MB = 400.0  # a configuration of 300,000 keys takes 330
CONTROLS = ["\x1b[31mred", "\x1b]0;title\x07", "a\rb", "\x7f", "\x9b2J", "\x1b[2J\x1b[H"]


def refused_soon(arena, outcome):
    """Findings where what asks for too much was not refused, or not at once."""
    limit_s = SECONDS * (10 if arena.base.program.sanitized else 1)
    findings = []
    if outcome.exit_code not in (1, 2):
        findings.append(("bound", f"exit code {outcome.exit_code}, not refused"))
    if outcome.seconds > limit_s:
        findings.append(("bound", f"refused after {outcome.seconds:.1f} s"))
    return findings


def refusal(label, arguments, prepare=lambda arena: None):
    return Case(label, arguments, prepare, peak_mb=LITTLE_MB, after=refused_soon)


def long_list(item, count):
    return "[" + ", ".join([item] * count) + "]"


LISTS = {
    "imu.gyro.processes": "{type: random_constant, sigma_deg_h: 1}",
    "imu.accel.processes": "{type: random_constant, sigma_mg: 1}",
    "gnss.processes": "{type: gauss_markov, sigma_enu_m: [1, 1, 1], tau_s: 1}",
    "imu.vibration": "{window_s: [1, 2], sigma_gyro_deg_s: 1}",
    "estimate": "boresight",
    "strips": "{name: a, t0: 1, t1: 2}",
    "time_span_s": "1",
    "gnss.lever_arm_m": "1",
}
SCENARIO_LISTS = {
    "plan.lines": "[-150, 0, 150, 0, 200, 30]",
    "effects": "{effect: gyro_bias, value: [0.1, 0.1, 0.1]}",
    "imu.gyro.processes": "{type: random_constant, sigma_deg_h: 1}",
    "gnss.processes": "{type: gauss_markov, sigma_enu_m: [1, 1, 1], tau_s: 1}",
    "terrain": "1",
}
LARGE = {
    "imu.rate_hz": 1e9, "gnss.rate_hz": 1e9, "lidar.pulse_rate_hz": 1e9, "pairs.count": 10 ** 12,
    "plan.warm_up_s": 1e9, "terrain.relief_m": 1e9, "plan.turbulence.roll_deg": 1e9,
}


def list_case(base, rng):
    scenario = rng.random() < 0.4
    key, item = rng.choice(list((SCENARIO_LISTS if scenario else LISTS).items()))
    count = rng.choice([1001, 2000])
    change = f"{key}={long_list(item, count)}"
    if scenario:
        return refusal(f"scenario, {count} elements of {key}",
                       ["simulate", "scenario.yaml", "--set", change, "--out", "out"],
                       lay_scenario)
    return refusal(f"{count} elements of {key}",
                   ["calibrate", "flight", "--set", change, "--out", "out"])


def lay_scenario(arena):
    (arena.here / "scenario.yaml").write_text(arena.base.scenario)


def large_case(base, rng):
    key, value = rng.choice(list(LARGE.items()))
    return refusal(f"scenario, {key} of {value}",
                   ["simulate", "scenario.yaml", "--set", f"{key}={value}", "--out", "out"],
                   lay_scenario)


def key_case(base, rng):
    key = rng.choice([".".join(["a"] * 20000), "a" * 100000, "." * 50000,
                      "imu." + ".".join(["gyro"] * 5000), "gnss." * 10000 + "file"])
    return Case(f"--set with a key of {len(key)} characters",
                ["check", "flight", "--set", key + "=1"], echoes=key, peak_mb=LITTLE_MB,
                after=refused_soon)


def nested_case(base, rng):
    opening = rng.choice(["[", "{a: ", "- ", "? ", "!a ", "a:\n"])
    text = opening * (900000 // len(opening))
    return refusal(f"flight.yaml nests {short(opening)}", ["check", "flight"],
                   lambda arena: arena.write("flight.yaml", text))


def sweep_case(base, rng):
    text = rng.choice([
        "  pairs.count: [" + ",".join(map(str, range(150000))) + "]\n",
        "  pairs.count: {" + ",".join(f"v{i}: 1" for i in range(80000)) + "}\n",
        "".join(f"  k{i}: [1, 2]\n" for i in range(64)),
        "  pairs.count: [5]\nestimate: [foo]\n",
        "  estimate: [[], [gnss_lever_arn]]\n",
        "  pairs.count: {\"\\e[31mred\": 10, b: 20}\n"])

    def prepare(arena):
        lay_scenario(arena)
        (arena.here / "sweep.yaml").write_text("base: scenario.yaml\nsweep:\n" + text)

    return refusal(f"sweep {short(text)}", ["study", "--sweep", "sweep.yaml", "--out", "out"],
                   prepare)


def option_case(base, rng):
    words = rng.choice([
        ["calibrate", "flight", "--threads", "1000000000", "--out", "out"],
        ["monte-carlo", "scenario.yaml", "--flights", "1000000000", "--out", "out"],
        ["blind-check", "--flights", "1000000000000", "--out", "out"],
        ["match", "flight/strips/1.las", "flight/strips/2.txt", "--gsd", "1e-9", "--out", "out"],
        ["match", "flight/strips/1.las", "flight/strips/2.txt", "--gsd", "1e-300", "--out", "out"],
        ["calibrate", "flight", "--set", "network.node_rate_hz=1e9", "--out", "out"],
        ["calibrate", "flight", "--set", "lidar.pairs={strategy: max, count: 0}", "--out", "out"]])
    return refusal("options " + " ".join(words[:4]), words, lay_scenario)


def las_of_records(count, size):
    """LAS 1.4 without points that promises extended records, in a file with a hole."""
    header = bytearray(375)
    header[0:4] = b"LASF"
    header[24:26] = bytes([1, 4])
    struct.pack_into("<HI", header, 94, 375, 375)
    struct.pack_into("<BH", header, 104, 6, 30)
    struct.pack_into("<3d", header, 131, 0.001, 0.001, 0.001)
    struct.pack_into("<QI", header, 235, 375, count)
    return bytes(header), size


def las_case(base, rng):
    content, size = las_of_records(rng.choice([1, 10001, 2 ** 31, 2 ** 32 - 1]),
                                   rng.choice([300 << 30, 1 << 40]))

    def prepare(arena):
        path = arena.flight / "strips/3.las"
        path.write_bytes(content)
        os.truncate(path, size)

    command = rng.choice([["georef", "flight", "--out", "out"], ["match", "flight", "--out", "out"]])
    return refusal(f"{command[0]}, extended records in a file of {size} bytes", command, prepare)


def foreign_case(base, rng):
    """Files that are no data in the folder that `dn init` looks at."""
    rows = rng.choice(["500000 5200000 400 17 1 2 3\n", "1,2\n", "381000.5, 46.5, 6.5\n"])
    loop = rng.choice(["loop.txt", "lidar", "strips"])

    def prepare(arena):
        (arena.flight / "flight.yaml").unlink()
        arena.write("foreign.txt", rows * (60000000 // len(rows)))
        path = arena.flight / loop
        if path.is_dir():
            shutil.rmtree(path)
        path.symlink_to(loop)

    def after(arena, outcome):
        (arena.flight / "flight.yaml").unlink(missing_ok=True)
        return [] if outcome.exit_code == 0 else [("bound", f"exit code {outcome.exit_code}")]

    return Written(f"init, {len(rows)} bytes a row, link {loop}", ["init", "flight"], prepare,
                   peak_mb=LITTLE_MB, after=after, anywhere=True)


class Written(Case):
    """A command that writes next to its input."""

    def attack(self, arena):
        outcome, findings = super().attack(arena)
        return outcome, [f for f in findings if f[0] not in ("leftover", "input changed")]


def terminal_case(base, rng):
    """Names with control characters: what is printed has none."""
    word = rng.choice(CONTROLS)

    def prepare(arena):
        target = arena.here / word
        os.rename(arena.flight, target)
        arena.flight = target
        (target / "flight.yaml").unlink()

    if rng.random() < 0.5:
        return Written("init in " + short(word), ["init", word], prepare, echoes=word,
                       anywhere=True)
    return Case("check of " + short(word), ["check", word], prepare, echoes=word, anywhere=True)


KINDS = [list_case, large_case, key_case, nested_case, sweep_case, option_case, las_case,
         foreign_case, terminal_case]


def case(base, rng, number):
    return KINDS[number % len(KINDS)](base, rng)
