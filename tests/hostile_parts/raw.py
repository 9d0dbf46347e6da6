"""Damages the bytes of any file, and the records of an SBET file."""

import struct

RECORD = 136  # bytes of an SBET record
INSERTED = [b"\0", b"\xff\xfe", b"x", b"\n", b",", b"\x1b]0;x\x07", b"-", b"."]
DOUBLES = [float("nan"), float("inf"), 1e308, -1e308, 0.0, 1e9, -1.0, 5e-324, 7.0]


def truncate(rng, content, at):
    return content[:at]


def flip(rng, content, at):
    return flipped(rng, content, 1)


def flip_many(rng, content, at):
    return flipped(rng, content, 1000)


def flipped(rng, content, count):
    changed = bytearray(content)
    for _ in range(count):
        changed[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def insert(rng, content, at):
    return content[:at] + rng.choice(INSERTED) + content[at:]


def cut_out(rng, content, at):
    return content[:at] + content[at + rng.choice([1, 7, 136, 5000]):]


def zero_some(rng, content, at):
    return content[:at] + b"\0" * 100 + content[at + 100:]


def empty(rng, content, at):
    return b""


def zeros(rng, content, at):
    return b"\0" * len(content)


def noise(rng, content, at):
    return rng.randbytes(len(content) // 8)


def crlf(rng, content, at):
    return content.replace(b"\n", b"\r\n")


def carriage_returns(rng, content, at):
    return content.replace(b"\n", b"\r")


def byte_order_mark(rng, content, at):
    return b"\xef\xbb\xbf" + content


def utf16(rng, content, at):
    return content.decode("latin-1").encode("utf-16")


def no_newline(rng, content, at):
    return content.rstrip(b"\n")


def spaces(rng, content, at):
    return content.replace(b",", b" , \t ")


def twice(rng, content, at):
    return content + content


CHANGES = [truncate, truncate, flip, flip_many, insert, cut_out, zero_some, empty, zeros, noise,
           crlf, carriage_returns, byte_order_mark, utf16, no_newline, spaces, twice]


def damaged(rng, content):
    """Returns the damaged content and a description of the damage."""
    change = rng.choice(CHANGES)
    at = rng.randrange(len(content))
    return change(rng, content, at), f"{change.__name__} at byte {at}"


def one_value(rng, records, at, column):
    value = rng.choice(DOUBLES)
    struct.pack_into("<d", records[at], 8 * column, value)
    return records


def a_column(rng, records, at, column):
    value = rng.choice(DOUBLES)
    for record in records:
        struct.pack_into("<d", record, 8 * column, value)
    return records


def swap_records(rng, records, at, column):
    other = rng.randrange(len(records))
    records[at], records[other] = records[other], records[at]
    return records


def double_record(rng, records, at, column):
    return records[:at] + records[at:at + 1] + records[at:]


def delete_records(rng, records, at, column):
    return records[:at] + records[at + rng.choice([1, 2, len(records) // 2]):]


def big_endian(rng, records, at, column):
    return [struct.pack(">17d", *struct.unpack("<17d", record)) for record in records]


def reverse_records(rng, records, at, column):
    return records[::-1]


def one_record(rng, records, at, column):
    return [records[at]]


RECORD_CHANGES = [one_value, one_value, a_column, swap_records, double_record, delete_records,
                  big_endian, reverse_records, one_record]


def damaged_sbet(rng, content):
    records = [bytearray(content[i:i + RECORD]) for i in range(0, len(content), RECORD)]
    at = rng.randrange(len(records))
    column = rng.randrange(17)
    change = rng.choice(RECORD_CHANGES)
    content = b"".join(change(rng, records, at, column))
    return content, f"{change.__name__} at record {at} value {column + 1}"
