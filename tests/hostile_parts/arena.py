"""The folder of one attack: a copy of the flight to be damaged, and files that must not change.

    here/          the working directory; must contain only `flight`, `out` and the files that the
                   attack itself writes there
    here/flight    the flight
    here/out       the results
    tmp/           TMPDIR
"""

import hashlib
import os
import pathlib
import re
import shutil
import stat

LARGEST_HASHED = 1 << 26  # bytes; larger files are identified by size and time
CANARY = "CANARY"  # file that an injected command would create


class Arena:
    def __init__(self, folder, base):
        self.folder = pathlib.Path(folder)
        self.base = base
        self.here = self.folder / "here"
        self.flight = self.here / "flight"
        self.out = self.here / "out"
        self.here.mkdir(parents=True)
        (self.folder / "tmp").mkdir(mode=0o777)
        shutil.copytree(base.flight, self.flight)
        self.before = {}
        self.truth_deg = read_truth(base.flight)

    def remember(self):
        """Stores the contents before the run. Call it after preparing the attack."""
        self.before = self.contents()

    def contents(self):
        """Returns path and hash of all files in `here` and `tmp`."""
        found = {}
        for root, folders, files in os.walk(self.folder, onerror=None):
            for name in folders + files:
                path = os.path.join(root, name)
                found[os.path.relpath(path, self.folder)] = fingerprint(path)
        return found

    def open_for_nobody(self):
        for root, folders, files in os.walk(self.folder):
            for name in folders + files:
                path = os.path.join(root, name)
                if not os.path.islink(path):
                    os.chown(path, 65534, 65534)
        os.chown(self.folder, 65534, 65534)

    def write(self, name, content):
        path = self.flight / name
        path.parent.mkdir(exist_ok=True)
        if path.is_symlink() or path.exists():
            path.unlink()
        path.write_bytes(content if isinstance(content, bytes) else content.encode())


def read_truth(folder):
    """Returns the simulated boresight, deg."""
    text = (pathlib.Path(folder) / "truth.yaml").read_text()
    numbers = re.search(r"boresight_deg: \[(.*)\]", text).group(1)
    return [float(x) for x in numbers.split(",")]


def fingerprint(path):
    state = os.lstat(path)
    mode = state.st_mode
    if stat.S_ISLNK(mode):
        return "link " + os.readlink(path)
    if not stat.S_ISREG(mode):
        return "special"
    if state.st_size > LARGEST_HASHED:
        return f"{state.st_size} bytes at {state.st_mtime_ns}"
    try:
        with open(path, "rb") as stream:
            return hashlib.blake2b(stream.read()).hexdigest()
    except OSError:
        return "unreadable"
