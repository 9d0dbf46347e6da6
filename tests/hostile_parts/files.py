"""Every file of a flight damaged: bytes, rows, columns, times, and what lies there instead of it."""

import os
import struct

from .cases import ALL, CALIBRATE, CHECK, GAUSS_HELMERT, SMOOTH, Case
from .flights import text_trajectory
from .program import Conditions
from .values import TOUCH, short

CELLS = ["nan", "-nan", "inf", "-inf", "1e999", "1e308", "-1e308", "1e-320", "0", "-1", "1e9", "9" * 400, "0x10", "", " ",
         "abc", "1e", "1,5", "1;5", "1.2.3", "--1", "NULL", "#", "\"1\"", "$(" + TOUCH + ")", "1e5", "-0.0", "ü", "\x00", "\x1b[2J"]
RECORD = 136  # bytes of SBET


def rows_of(content):
    """The rows without comments, comma separated."""
    rows = [row for row in content.decode().splitlines() if not row.startswith("#")]
    return [row if "," in row else ",".join(row.split()) for row in rows]


def text(rows):
    return ("\n".join(rows) + "\n").encode()


def change_rows(rng, rows):
    """Rows damaged, and how."""
    n = len(rows)
    at = rng.randrange(n)
    width = len(rows[0].split(","))
    column = rng.randrange(width)
    kind = rng.choice([
        "cell", "cell", "cell", "cells", "delete row", "delete rows", "delete column", "double row", "double rows",
        "swap rows", "swap columns", "reverse", "shuffle", "sort", "time back", "time forward", "times scaled", "times shifted",
        "times equal", "column scaled", "column negated", "column zero", "column constant", "row short", "row long", "semicolons", "tabs",
        "decimal commas", "one row", "two rows", "double file", "empty lines", "comments", "header", "long line", "rows of others"])
    label = f"{kind} at line {at + 1} column {column + 1}"

    def cells(row):
        return row.split(",")

    def with_cell(row, value):
        words = cells(row)
        words[column] = value
        return ",".join(words)

    def each(change):
        return [",".join(change(cells(row))) for row in rows]

    def scaled(words, index, factor):
        words[index] = repr(float(words[index]) * factor)
        return words

    def moved(words, index, shift):
        words[index] = repr(float(words[index]) + shift)
        return words

    times = [0, 1] if width in (8, 14) else [0]
    few = rng.choice([1, 2, 5, 50, n // 2])
    if kind == "cell":
        value = rng.choice(CELLS)
        rows[at] = with_cell(rows[at], value)
        label += ": " + short(value)
    elif kind == "cells":
        value = rng.choice(CELLS)
        share = rng.choice([0.01, 0.1, 0.5, 1])
        rows = [with_cell(row, value) if rng.random() < share else row for row in rows]
        label += f": {share:.0%} {short(value)}"
    elif kind == "delete row":
        del rows[at]
    elif kind == "delete rows":
        del rows[at:at + few]
        label += f": {few}"
    elif kind == "delete column":
        rows = each(lambda words: words[:column] + words[column + 1:])
    elif kind == "double row":
        rows.insert(at, rows[at])
    elif kind == "double rows":
        rows[at:at] = rows[at:at + few]
        label += f": {few}"
    elif kind == "swap rows":
        other = rng.randrange(n)
        rows[at], rows[other] = rows[other], rows[at]
    elif kind == "swap columns":
        other = rng.randrange(width)
        label += f" and {other + 1}"

        def swap(words):
            words[column], words[other] = words[other], words[column]
            return words
        rows = each(swap)
    elif kind == "reverse":
        rows.reverse()
    elif kind == "shuffle":
        rng.shuffle(rows)
    elif kind == "sort":
        rows.sort(key=lambda row: cells(row)[column])
    elif kind in ("time back", "time forward"):
        size = rng.choice([1e-9, 1e-3, 0.04, 1, 100, 604800, 1e9])
        shift = -size if kind == "time back" else size
        tail = [",".join(moved(cells(row), 0, shift)) for row in rows[at:]]
        rows[at:] = tail
        label += f": {shift}"
    elif kind == "times scaled":
        factor = rng.choice([1e3, 1e-3, 1e6, 1e9, 1.0001, 0, -1])
        for index in times:
            rows = [",".join(scaled(cells(row), index, factor)) for row in rows]
        label += f": {factor}"
    elif kind == "times shifted":
        shift = rng.choice([0.001, 0.02, -0.1, 1, -10, 604800, -604800, 1e9, 315964800])
        for index in times:
            rows = [",".join(moved(cells(row), index, shift)) for row in rows]
        label += f": {shift}"
    elif kind == "times equal":
        rows = each(lambda words: [cells(rows[0])[0]] + words[1:])
    elif kind == "column scaled":
        factor = rng.choice([1.001, 1.1, 0.3048, 3.2808, 57.2958, 0.0174533, 9.80665, 0.10197, 1000, 1e-6, 1e200])
        rows = each(lambda words: scaled(words, column, factor))
        label += f": {factor}"
    elif kind == "column negated":
        rows = each(lambda words: scaled(words, column, -1))
    elif kind == "column zero":
        rows = each(lambda words: scaled(words, column, 0))
    elif kind == "column constant":
        rows = each(lambda words: words[:column] + [cells(rows[at])[column]] + words[column + 1:])
    elif kind == "row short":
        rows[at] = ",".join(cells(rows[at])[:column])
    elif kind == "row long":
        rows[at] += ",1" * rng.choice([1, 6, 100000])
    elif kind == "semicolons":
        rows = [row.replace(",", ";") for row in rows]
    elif kind == "tabs":
        rows = [row.replace(",", "\t") for row in rows]
    elif kind == "decimal commas":
        rows = [row.replace(",", ";").replace(".", ",") for row in rows]
    elif kind == "one row":
        rows = [rows[at]]
    elif kind == "two rows":
        rows = rows[at:at + 2]
    elif kind == "double file":
        rows += rows
    elif kind == "empty lines":
        rows = [row + "\n" for row in rows]
    elif kind == "comments":
        rows = ["#" + row if rng.random() < 0.3 else row for row in rows]
    elif kind == "header":
        rows.insert(0, "t,a,b,c")
    elif kind == "long line":
        rows.insert(at, "1" * 2000000)
    elif kind == "rows of others":
        rows = [rows[(i + 1) % n].split(",")[0] + "," + ",".join(cells(row)[1:]) for i, row in enumerate(rows)]
    return rows, label


def change_bytes(rng, content):
    kind = rng.choice(["truncate", "truncate", "flip", "flips", "insert", "cut out", "empty", "zeros", "noise", "crlf", "cr",
                       "bom", "utf16", "nul", "no newline", "spaces", "double"])
    at = rng.randrange(len(content))
    label = f"{kind} at byte {at}"
    if kind == "truncate":
        return content[:at], label
    if kind in ("flip", "flips"):
        changed = bytearray(content)
        for _ in range(1 if kind == "flip" else 1000):
            changed[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
        return bytes(changed), label
    if kind == "insert":
        return content[:at] + rng.choice([b"\0", b"\xff\xfe", b"x", b"\n", b",", b"\x1b]0;x\x07", b"-", b"."]) + content[at:], label
    if kind == "cut out":
        return content[:at] + content[at + rng.choice([1, 7, 136, 5000]):], label
    if kind == "empty":
        return b"", kind
    if kind == "zeros":
        return b"\0" * len(content), kind
    if kind == "noise":
        return rng.randbytes(len(content) // 8), kind
    if kind == "crlf":
        return content.replace(b"\n", b"\r\n"), kind
    if kind == "cr":
        return content.replace(b"\n", b"\r"), kind
    if kind == "bom":
        return b"\xef\xbb\xbf" + content, kind
    if kind == "utf16":
        return content.decode("latin-1").encode("utf-16"), kind
    if kind == "nul":
        return content[:at] + b"\0" * 100 + content[at + 100:], label
    if kind == "no newline":
        return content.rstrip(b"\n"), kind
    if kind == "spaces":
        return content.replace(b",", b" , \t "), kind
    return content + content, kind


def change_records(rng, content):
    """SBET: a value, or whole records."""
    n = len(content) // RECORD
    records = [bytearray(content[i * RECORD:(i + 1) * RECORD]) for i in range(n)]
    at = rng.randrange(n)
    column = rng.randrange(17)
    kind = rng.choice(["value", "value", "values", "swap", "double", "delete", "byte order", "reverse", "one record"])
    label = f"{kind} at record {at} value {column + 1}"
    value = rng.choice([float("nan"), float("inf"), 1e308, -1e308, 0.0, 1e9, -1.0, 5e-324, 7.0])
    if kind == "value":
        records[at][column * 8:column * 8 + 8] = struct.pack("<d", value)
        label += f": {value}"
    elif kind == "values":
        for record in records:
            record[column * 8:column * 8 + 8] = struct.pack("<d", value)
        label += f": {value}"
    elif kind == "swap":
        other = rng.randrange(n)
        records[at], records[other] = records[other], records[at]
    elif kind == "double":
        records.insert(at, records[at])
    elif kind == "delete":
        del records[at:at + rng.choice([1, 2, n // 2])]
    elif kind == "byte order":
        records = [struct.pack(">17d", *struct.unpack("<17d", record)) for record in records]
    elif kind == "reverse":
        records.reverse()
    else:
        records = [records[at]]
    return b"".join(records), label


def change_thing(rng, arena, path):
    """Something else lies where the file should be."""
    kind = rng.choice(["missing", "folder", "fifo", "zero", "full", "null", "dangling link", "link to itself", "link to itself by two",
                       "unreadable", "socket", "link to a folder", "sparse", "proc"])
    if path.exists() or path.is_symlink():
        path.unlink()
    if kind == "folder":
        path.mkdir()
    elif kind in ("fifo", "socket"):
        os.mkfifo(path) if kind == "fifo" else make_socket(path)
    elif kind in ("zero", "full", "null"):
        path.symlink_to(f"/dev/{kind}")
    elif kind == "dangling link":
        path.symlink_to("nowhere")
    elif kind == "link to itself":
        path.symlink_to(path.name)
    elif kind == "link to itself by two":
        path.symlink_to("other_link")
        (path.parent / "other_link").symlink_to(path.name)
    elif kind == "unreadable":
        path.write_bytes(b"1,2,3\n")
        path.chmod(0)
    elif kind == "link to a folder":
        path.symlink_to("/etc")
    elif kind == "sparse":
        with open(path, "wb") as stream:
            stream.truncate(20 << 30)
    elif kind == "proc":
        path.symlink_to("/proc/self/environ")
    return kind


def make_socket(path):
    import socket
    here = os.open(".", os.O_RDONLY)
    try:
        os.chdir(path.parent)
        with socket.socket(socket.AF_UNIX) as end:
            end.bind(path.name)
    finally:
        os.fchdir(here)
        os.close(here)


FILES = {
    "IMU.txt": (CALIBRATE, CALIBRATE, SMOOTH, CHECK),
    "GPS.txt": (CALIBRATE, CALIBRATE, SMOOTH, CHECK),
    "lidar/1_2.txt": (CALIBRATE, CALIBRATE, CALIBRATE, GAUSS_HELMERT, CHECK),
    "trajectory.out": (GAUSS_HELMERT, GAUSS_HELMERT, ALL),
    "trajectory.txt": (GAUSS_HELMERT,),
    "trajectory_sigma.txt": (GAUSS_HELMERT,),
    "trajectory_covariance.txt": (GAUSS_HELMERT,),
    "initial_guess.out": (CALIBRATE, SMOOTH),
    "initial_guess.txt": (CALIBRATE, SMOOTH),
    "reference.out": (CALIBRATE, SMOOTH),
    "reference.txt": (CALIBRATE,),
    "flight.yaml": (CALIBRATE, CHECK),
    "truth.yaml": (CALIBRATE,),
}


def lay(arena, name):
    """The file as it should be, made of another where the flight has none."""
    path = arena.flight / name
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
    path = lay(arena, name)
    draw = rng.random()
    if draw < 0.1 and name != "truth.yaml":
        return change_thing(rng, arena, path)
    content = path.read_bytes()
    if name.endswith(".out") and draw < 0.6:
        changed, label = change_records(rng, content)
    elif name.endswith(".txt") and draw < 0.75:
        rows, label = change_rows(rng, rows_of(content))
        changed = text(rows)
    else:
        changed, label = change_bytes(rng, content)
    arena.write(name, changed)
    return label


STRANGE_NAMES = ["a b", "a'b", 'a"b', "a;b", "a\nb", "a\tb", "-rf", "--out", "ü漢🛩", "a\\b", "%s%n", "x" * 250, "a\x1b[2Jb", "a\x07b",
                 f"$({TOUCH})", f"`{TOUCH}`", f"a\n!{TOUCH}\nb", f"'; {TOUCH}; '", f'"; {TOUCH}; "', "*", "?", "~", "#", "a:b", "\udcff",
                 "flight.yaml", "a\nsystem('" + TOUCH + "')\nb", "[a]", "{a,b}", "&", "|", "..."]


def name_case(rng):
    """The folder of the flight or of the results has a strange name."""
    name = rng.choice(STRANGE_NAMES)
    as_out = rng.random() < 0.4
    command = rng.choice(["calibrate", "smooth", "check"])

    def prepare(arena):
        if as_out:
            arena.out = arena.here / name
            return
        target = arena.here / name
        os.rename(os.fsencode(arena.flight), os.fsencode(str(target)) if "\udcff" not in name else os.fsencode(target))
        arena.flight = target
        if rng.random() < 0.5:
            config = target / "flight.yaml"
            config.write_text(config.read_text().replace("name: small\n", ""))

    words = [command, "./" + ("flight" if as_out else name), "--out", "./" + name if as_out else "out"]
    return Case(f"{command}, {'results' if as_out else 'flight'} in a folder named {short(name)}", words, prepare, echoes=name,
                anywhere=as_out)


def case(base, rng, number):
    if rng.random() < 0.06:
        return name_case(rng)
    name = list(FILES)[number % len(FILES)]
    command = rng.choice(FILES[name])
    result = Case(name, command)

    def prepare(arena):
        how = damage(rng, arena, name)
        result.label = f"{name}: {how}"
        if how == "unreadable":
            result.conditions = Conditions(as_nobody=True)
        if name == "flight.yaml":
            result.needs_location = False

    result.prepare = prepare
    return result
