#!/usr/bin/env python3
"""Writes dn.1 and a dn-<command>.1 for each command from the help texts of the program.

usage: man_pages.py PROGRAM FOLDER
"""
import pathlib
import re
import subprocess
import sys

SECTION = re.compile(r"^([A-Z][\w ()]*):$")
ENTRY = re.compile(r"^  (\S.*)$")
USAGE = re.compile(r"^Usage: (.*)$")
EXAMPLE = re.compile(r"^Example: (.*)$")

COLUMN = 30  # where descriptions start in a help text

EXIT_STATUS = [
    ("0", "The work succeeded."),
    ("1", "The work failed, or its result must not be relied on."),
    ("2", "Wrong usage or configuration."),
    ("130", "Interrupted."),
]


def escape(text):
    """A line of text for roff."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text[:1] in (".", "'") else text


def split_entry(line):
    """Name and description of '  --out TEXT REQUIRED     Results'.

    The description starts at a fixed column, or on the next line if the name is too long for that.
    """
    if len(line) > COLUMN and line[COLUMN - 1] == " ":
        return line[:COLUMN].strip(), line[COLUMN:].strip()
    return line.strip(), ""


class Help:
    """A help text in parts."""

    def __init__(self, text):
        self.description, self.usage, self.notes, self.example = [], "", [], []
        self.sections = []  # (title, [[name, description], ...])
        for line in text.splitlines():
            self.add(line)

    def add(self, line):
        section, usage, example = SECTION.match(line), USAGE.match(line), EXAMPLE.match(line)
        if usage:
            self.usage = usage.group(1)
        elif section:
            self.sections.append((section.group(1), []))
        elif example or self.example:
            self.example.append(example.group(1) if example else line.strip())
        elif self.notes:
            self.notes.append(line.strip())
        elif self.sections and line.startswith("    ") and self.sections[-1][1]:
            entry = self.sections[-1][1][-1]
            entry[1] = (entry[1] + " " + line.strip()).strip()
        elif self.sections and ENTRY.match(line):
            self.sections[-1][1].append(list(split_entry(line)))
        elif line.strip():
            (self.notes if self.sections else self.description).append(line.strip())


def help_of(program, *command):
    text = subprocess.run([program, *command, "--help"], check=True, capture_output=True, text=True)
    return Help(text.stdout)


def entries(pairs):
    lines = []
    for name, description in pairs:
        # A long list of choices may be broken after a comma.
        lines += [".TP", f".B {escape(name)}".replace(",", ",\\:"), escape(description or " ")]
    return lines


def first_sentence(lines):
    if len(lines) == 1:
        return lines[0]
    return re.split(r"[.:;] ", " ".join(lines))[0].removesuffix(".")


def page(name, version, help_text, see_also):
    summary = first_sentence(help_text.description) or name
    lines = [
        f'.TH {name.upper()} 1 "" "{version}" "User Commands"',
        ".ad l",
        ".nh",
        ".SH NAME",
        f"{escape(name)} \\- {escape(summary)}",
        ".SH SYNOPSIS",
        f".B {escape(help_text.usage or name)}",
        ".SH DESCRIPTION",
        *map(escape, help_text.description),
    ]
    for title, pairs in help_text.sections:
        lines += [f'.SH "{title.upper()}"', *entries(pairs)]
    if help_text.notes:
        lines += [".SH NOTES", *map(escape, filter(None, help_text.notes))]
    lines += [".SH \"EXIT STATUS\"", *entries(EXIT_STATUS)]
    if help_text.example:
        lines += [".SH EXAMPLE", ".nf", *map(escape, filter(None, help_text.example)), ".fi"]
    others = ", ".join(f".BR {escape(other)} (1)" for other in see_also)
    lines += [".SH \"SEE ALSO\"", *others.replace(", .BR", " ,\n.BR").split("\n")]
    return "\n".join(lines) + "\n"


def command_names(top):
    for title, pairs in top.sections:
        if title in ("Subcommands", "Commands"):
            return [name.split()[0] for name, _ in pairs]
    raise SystemExit("man_pages: the help of the program lists no commands")


def main():
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True)
    version = version.stdout.strip()
    top = help_of(program)
    commands = command_names(top)
    names = [f"dn-{command}" for command in commands]
    (folder / "dn.1").write_text(page("dn", version, top, names), encoding="utf-8")
    for command, name in zip(commands, names):
        text = page(name, version, help_of(program, command), ["dn"])
        (folder / f"{name}.1").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
