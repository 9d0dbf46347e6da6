"""Makes small point clouds for the attacked flight, and damages the fields of a LAS file."""

import math
import struct

HEADER = 227
RECORD = 28
# Byte offset and type of numbers in the header, in the first record, or after it.
FIELDS = [(6, "H"), (24, "B"), (25, "B"), (94, "H"), (96, "I"), (100, "I"), (104, "B"), (105, "H"),
          (107, "I"), (131, "d"), (139, "d"), (147, "d"), (155, "d"), (163, "d"), (HEADER, "i"),
          (HEADER + 14, "B"), (HEADER + 20, "d"), (HEADER + RECORD + 20, "d")]
WHOLE = [0, 1, 2, 7, 100, 226, 228, 255, 256, 65535, 65536, 2 ** 31 - 1, 2 ** 31, 2 ** 32 - 1]
REAL = [float("nan"), float("inf"), -float("inf"), 0.0, -0.001, 1e-300, 1e300, 5e-324, 3.5e8, 1e9,
        -1.0, 604800.0]


def epochs(first_s, last_s, count):
    return [first_s + (last_s - first_s) * i / count for i in range(count)]


def las(epochs_s):
    """Returns a LAS 1.2 file with point format 1 in the mapping frame."""
    header = bytearray(HEADER)
    header[0:4] = b"LASF"
    header[24:26] = bytes([1, 2])
    struct.pack_into("<HII", header, 94, HEADER, HEADER, 0)
    struct.pack_into("<BHI", header, 104, 1, RECORD, len(epochs_s))
    struct.pack_into("<3d", header, 131, 0.001, 0.001, 0.001)
    records = b""
    for i, t_s in enumerate(epochs_s):
        record = bytearray(RECORD)
        struct.pack_into("<iiiHB", record, 0, 100 * i, -70 * i, 30 * (i % 7), i % 100, 1)
        struct.pack_into("<d", record, 20, t_s)
        records += bytes(record)
    return bytes(header) + records


def text(epochs_s):
    return "".join(f"{t_s!r}, {i}, {-i}, {i % 5}, {200 + i % 9}, 1.5, {100 * math.sin(i)!r}\n"
                   for i, t_s in enumerate(epochs_s))


def damaged_las(rng, content):
    """Returns the LAS file with a hostile number in one field, and its description."""
    at, kind = rng.choice(FIELDS)
    value = rng.choice(REAL) if kind == "d" else rng.choice(WHOLE) % (1 << 8 * struct.calcsize(kind))
    if kind == "i":
        value -= 1 << 31
    changed = bytearray(content)
    struct.pack_into("<" + kind, changed, at, value)
    return bytes(changed), f"{value} at byte {at}"
