"""The rules that every run must obey, whatever its input."""

import json
import math
import os
import re

from .arena import CANARY
from .rotation import difference_deg

ALLOWED_EXITS = (0, 1, 2, 130)
WRONG_SIGMAS = 6.0  # error of an angle beyond which the verdict `calibrated` is wrong
LARGEST_SIGMA_DEG = 2.0  # largest sigma of an angle with the verdict `calibrated`
PEAK_MB = 600.0
LONGEST_LINE = 1500
SANITIZERS = re.compile(r"(Address|Leak|Thread|Memory|UndefinedBehavior)Sanitizer|runtime error:")
CRASH_WORDS = re.compile(r"terminate called|Segmentation|core dumped|Check failed|double free")
ERROR_LINE = re.compile(r"^dn(?: [\w-]+)?: error: (.*)$")
EMPTY_WORDS = re.compile(
    r"\bdimension\b|\binternal\b|basic_string|vector::|bad_alloc|std::|\bstod\b|Eigen|_M_|__cxx|"
    r"errno|\(null\)|\d{60,}")
NOT_A_NUMBER = re.compile(r"(?<![\w'\"])[-+]?(?:nan|inf)(?![\w'\"])", re.IGNORECASE)
NOT_STARTED = "error while loading shared libraries"  # the loader has too little memory
LEFTOVER = re.compile(r"\.part($|/)|staging|\.tmp($|/)|(^|/)core($|\.)")
CONTROL = re.compile(r"[\x00-\x08\x0b-\x1f\x7f]")
USAGE = re.compile(r"; see dn (?:[\w-]+ )?--help$", re.MULTILINE)
CUT_WORD = re.compile(r"([^\s']{40,})\.\.\.([^\s']*)")
LOCATION = re.compile(r"\.ya?ml:\d+")


def judge(outcome, arena, needs_location=False, echoes="", heard=True, peak_mb=PEAK_MB,
          anywhere=False):
    """Returns findings as (rule, text). `echoes`: text of the attack that a message may repeat."""
    findings = []
    findings += judge_end(outcome, arena, peak_mb)
    if outcome.exit_code in (1, 2) and heard:
        findings += judge_message(outcome, needs_location, echoes)
    findings += judge_output(outcome, echoes)
    findings += judge_folder(arena, anywhere)
    findings += judge_result(outcome, arena)
    return findings


def judge_end(outcome, arena, peak_mb=PEAK_MB):
    if NOT_STARTED in outcome.err:
        return []
    findings = []
    if outcome.timed_out:
        findings.append(("hang", f"still running after {outcome.seconds:.0f} s"))
    elif outcome.exit_code is None:
        findings.append(("crash", f"ended by signal {outcome.signal}"))
    elif outcome.exit_code not in ALLOWED_EXITS:
        findings.append(("exit code", f"{outcome.exit_code}: {last_line(outcome.err)}"))
    for rule in (SANITIZERS, CRASH_WORDS):
        found = rule.search(outcome.err)
        if found:
            findings.append(("crash", outcome.err[found.start():found.start() + 300]))
    if not arena.base.program.sanitized and outcome.peak_mb > peak_mb:
        findings.append(("memory", f"{outcome.peak_mb:.0f} MB"))
    return findings


def last_line(text):
    lines = text.strip().splitlines()
    return lines[-1][:300] if lines else "(nothing on stderr)"


def judge_message(outcome, needs_location, echoes):
    lines = outcome.err.split("\n")
    errors = [line for line in lines if ERROR_LINE.match(line)]
    usage = outcome.exit_code == 2 and USAGE.search(outcome.err)
    if len(errors) != 1:
        return [("message", f"{len(errors)} error lines: {last_line(outcome.err)}")]
    message = ERROR_LINE.match(errors[0]).group(1)
    needs_location = needs_location and outcome.exit_code == 2 and not usage
    return [("message", f"{what}: {errors[0][:300]}")
            for what in bad_in(message, needs_location, echoes)
            ] + [("message", "control characters: " + repr(line[:200]))
                 for line in lines if CONTROL.search(line)][:1]


def judge_output(outcome, echoes):
    """Checks the text on stdout, which people and terminals read."""
    for line in outcome.out.split("\n"):
        if CONTROL.search(line):
            return [("output", "control characters: " + repr(line[:200]))]
        if NOT_A_NUMBER.search(line) and not NOT_A_NUMBER.search(echoes):
            return [("output", "not a number: " + line[:200])]
    return []


def without_echoes(message, echoes):
    """Returns the message without the text of the attack, which may be cut in the middle."""
    if len(echoes) <= 2:
        return message
    text = message.replace(echoes, "")
    for begin, end in CUT_WORD.findall(text):
        if begin[-40:] in echoes and end[:20] in echoes:
            text = text.replace(f"{begin}...{end}", "")
    return text


def bad_in(message, needs_location, echoes):
    text = without_echoes(message, echoes)
    bad = []
    if len(message.strip()) < 12:
        bad.append("says nothing")
    if len(message) > LONGEST_LINE:
        bad.append(f"{len(message)} characters")
    found = EMPTY_WORDS.search(text)
    if found:
        bad.append(f"'{found.group(0)[:40]}'")
    if NOT_A_NUMBER.search(text) and not NOT_A_NUMBER.search(echoes):
        bad.append("not a number")
    if needs_location and not LOCATION.search(message):
        bad.append("no location")
    return bad


def judge_folder(arena, anywhere=False):
    findings = []
    after = arena.contents()
    for path, content in arena.before.items():
        if path.startswith("here/out/") or content == "special":
            continue
        if after.get(path) != content:
            findings.append(("input changed", path))
    for path in sorted(set(after) - set(arena.before)):
        inside = path == "here/out" or path.startswith("here/out/")
        if os.path.basename(path) == CANARY:
            findings.append(("command run", path))
        elif not inside and not anywhere or LEFTOVER.search(path):
            findings.append(("leftover", path))
    return findings


def judge_result(outcome, arena):
    findings = []
    names = ("result.json", "result_dn.json", "result_gh.json")
    for name in names:
        path = arena.out / name
        if str(os.path.relpath(path, arena.folder)) in arena.before or not path.exists():
            continue
        try:
            result = json.loads(path.read_text())
        except ValueError:
            findings.append(("half written", name))
            continue
        findings += judge_boresight(outcome, result, arena.truth_deg)
    return findings


def judge_boresight(outcome, result, truth_deg):
    verdict = result["assessment"]["verdict"]
    if outcome.exit_code == 0 and verdict in ("contradicted", "not_observable"):
        return [("exit code", f"0 with the verdict {verdict}")]
    if outcome.exit_code == 2:
        return [("half written", f"exit code 2, but a result exists: {last_line(outcome.err)}")]
    if verdict != "calibrated":
        return []
    sigmas = result["boresight"]["sigma_deg"]
    angles = result["boresight"]["angles_deg"]
    if any(s is None or not math.isfinite(s) or s <= 0 or s > LARGEST_SIGMA_DEG for s in sigmas):
        return [("wrong result", f"calibrated with sigmas {sigmas} deg")]
    errors = [abs(d) / s for d, s in zip(difference_deg(angles, truth_deg), sigmas)]
    if max(errors) > WRONG_SIGMAS:
        sigma0 = result["adjustment"]["sigma0"]
        return [("wrong result", f"calibrated, {max(errors):.1f} sigmas off, sigma0 {sigma0:.3g}")]
    return []
