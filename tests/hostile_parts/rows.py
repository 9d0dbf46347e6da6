"""Damages rows and columns of a text file."""

import dataclasses
import random

from .arena import CANARY
from .values import short

CELLS = ["nan", "-nan", "inf", "-inf", "1e999", "1e308", "-1e308", "1e-320", "0", "-1", "1e9",
         "9" * 400, "0x10", "", " ", "abc", "1e", "1,5", "1;5", "1.2.3", "--1", "NULL", "#", '"1"',
         "corner", f"$(touch {CANARY})", "1e5", "-0.0", "ü", "\x00", "\x1b[2J"]
SHIFTS_S = [1e-9, 1e-3, 0.04, 1, 100, 604800, 1e9]
FACTORS = [1.001, 1.1, 0.3048, 3.2808, 57.2958, 0.0174533, 9.80665, 0.10197, 1000, 1e-6, 1e200]


@dataclasses.dataclass
class Rows:
    """The rows of a file as cells, with the place to be damaged."""

    rng: random.Random
    cells: list
    at: int
    column: int

    @property
    def times(self):
        """Returns the columns with time tags; pairs have two, control points have the eighth."""
        columns = len(self.cells[0])
        return (0, 1) if columns in (8, 10, 14, 16) else (7,) if columns == 12 else (0,)

    def another(self, count):
        return self.rng.randrange(count)

    def few(self):
        return self.rng.choice([1, 2, 5, 50, len(self.cells) // 2])

    def scale(self, column, factor):
        self.change(column, lambda value: value * factor)

    def shift(self, column, by, begin=0):
        self.change(column, lambda value: value + by, begin)

    def change(self, column, function, begin=0):
        """Changes the numbers of a column; a header line and missing values stay."""
        for row in self.cells[begin:]:
            cell = row[column].strip()
            if cell != "-" and not cell[:1].isalpha():
                row[column] = repr(function(float(row[column])))


def cell(rows):
    value = rows.rng.choice(CELLS)
    rows.cells[rows.at][rows.column] = value
    return short(value)


def many_cells(rows):
    value = rows.rng.choice(CELLS)
    share = rows.rng.choice([0.01, 0.1, 0.5, 1])
    for row in rows.cells:
        if rows.rng.random() < share:
            row[rows.column] = value
    return f"{share:.0%} {short(value)}"


def delete_row(rows):
    del rows.cells[rows.at]


def delete_rows(rows):
    few = rows.few()
    del rows.cells[rows.at:rows.at + few]
    return few


def delete_column(rows):
    for row in rows.cells:
        del row[rows.column]


def double_rows(rows):
    few = rows.few()
    rows.cells[rows.at:rows.at] = [list(row) for row in rows.cells[rows.at:rows.at + few]]
    return few


def double_file(rows):
    rows.cells += [list(row) for row in rows.cells]


def swap_rows(rows):
    other = rows.another(len(rows.cells))
    rows.cells[rows.at], rows.cells[other] = rows.cells[other], rows.cells[rows.at]
    return other + 1


def swap_columns(rows):
    other = rows.another(len(rows.cells[0]))
    for row in rows.cells:
        row[rows.column], row[other] = row[other], row[rows.column]
    return other + 1


def reverse(rows):
    rows.cells.reverse()


def shuffle(rows):
    rows.rng.shuffle(rows.cells)


def shuffle_column(rows):
    column = [row[rows.column] for row in rows.cells]
    rows.rng.shuffle(column)
    for row, value in zip(rows.cells, column):
        row[rows.column] = value


def sort(rows):
    rows.cells.sort(key=lambda row: row[rows.column])


def step_of_time(rows):
    step = rows.rng.choice([-1, 1]) * rows.rng.choice(SHIFTS_S)
    rows.shift(rows.times[0], step, rows.at)
    return step


def scale_times(rows):
    factor = rows.rng.choice([1e3, 1e-3, 1e6, 1e9, 1.0001, 0, -1])
    for column in rows.times:
        rows.scale(column, factor)
    return factor


def shift_times(rows):
    by = rows.rng.choice([0.001, 0.02, -0.1, 1, -10, 604800, -604800, 1e9, 315964800])
    for column in rows.times:
        rows.shift(column, by)
    return by


def equal_times(rows):
    for row in rows.cells:
        row[0] = rows.cells[0][0]


def scale_column(rows):
    factor = rows.rng.choice(FACTORS)
    rows.scale(rows.column, factor)
    return factor


def negate_column(rows):
    rows.scale(rows.column, -1)


def zero_column(rows):
    rows.scale(rows.column, 0)


def constant_column(rows):
    value = rows.cells[rows.at][rows.column]
    for row in rows.cells:
        row[rows.column] = value


def short_row(rows):
    del rows.cells[rows.at][rows.column:]


def long_row(rows):
    more = rows.rng.choice([1, 6, 100000])
    rows.cells[rows.at] += ["1"] * more
    return more


def long_number(rows):
    rows.cells[rows.at] = ["1" * 2000000]


def one_row(rows):
    rows.cells = [rows.cells[rows.at]]


def two_rows(rows):
    rows.cells = rows.cells[rows.at:rows.at + 2]


def times_of_the_next(rows):
    first = rows.cells[0][0]
    for row, following in zip(rows.cells, rows.cells[1:]):
        row[0] = following[0]
    rows.cells[-1][0] = first


def comments(rows):
    for row in rows.cells:
        if rows.rng.random() < 0.3:
            row[0] = "#" + row[0]


def header(rows):
    rows.cells.insert(0, ["t", "a", "b", "c"])


CHANGES = [cell, cell, cell, many_cells, delete_row, delete_rows, delete_column, double_rows,
           double_file, swap_rows, swap_columns, reverse, shuffle, shuffle_column, sort,
           step_of_time, step_of_time, scale_times, shift_times, equal_times, scale_column,
           negate_column, zero_column, constant_column, short_row, long_row, long_number, one_row,
           two_rows, times_of_the_next, comments, header]


def semicolons(text):
    return text.replace(",", ";")


def tabs(text):
    return text.replace(",", "\t")


def decimal_commas(text):
    return text.replace(",", ";").replace(".", ",")


def empty_lines(text):
    return text.replace("\n", "\n\n")


LAYOUTS = [semicolons, tabs, decimal_commas, empty_lines]


def read(content):
    """Returns the cells of all rows except comments."""
    lines = [line for line in content.decode().splitlines() if not line.startswith("#")]
    return [line.split(",") if "," in line else line.split() for line in lines]


def damaged(rng, content):
    """Returns the damaged text file and a description of the damage."""
    cells = read(content)
    if rng.random() < 0.1:
        layout = rng.choice(LAYOUTS)
        text = "".join(",".join(row) + "\n" for row in cells)
        return layout(text).encode(), layout.__name__
    rows = Rows(rng, cells, rng.randrange(len(cells)), rng.randrange(len(cells[0])))
    change = rng.choice(CHANGES)
    how = change(rows)
    label = f"{change.__name__} at line {rows.at + 1} column {rows.column + 1}"
    if how is not None:
        label += f": {how}"
    return "".join(",".join(row) + "\n" for row in rows.cells).encode(), label
