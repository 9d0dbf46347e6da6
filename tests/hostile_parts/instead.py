"""Replaces a file by something else, such as a folder, a pipe or a link."""

import os
import socket


def missing(path):
    pass


def folder(path):
    path.mkdir()


def fifo(path):
    os.mkfifo(path)


def listening_socket(path):
    here = os.open(".", os.O_RDONLY)
    try:
        os.chdir(path.parent)  # the path of a socket must be short
        with socket.socket(socket.AF_UNIX) as end:
            end.bind(path.name)
    finally:
        os.fchdir(here)
        os.close(here)


def link_to(target):
    def make(path):
        path.symlink_to(target)
    make.__name__ = f"link to {target}"
    return make


def link_to_itself(path):
    path.symlink_to(path.name)


def links_in_a_circle(path):
    other = path.parent / f"link_of_{path.name}"
    path.symlink_to(other.name)
    other.symlink_to(path.name)


def unreadable(path):
    path.write_bytes(b"1,2,3\n")
    path.chmod(0)


def sparse(path):
    with open(path, "wb") as stream:
        stream.truncate(20 << 30)


THINGS = [missing, folder, fifo, listening_socket, link_to_itself, links_in_a_circle, unreadable,
          sparse, link_to("nowhere"), link_to("/etc"), link_to("/dev/zero"), link_to("/dev/full"),
          link_to("/dev/null"), link_to("/proc/self/environ")]


def laid(rng, path):
    """Replaces the file. Returns the name of the replacement."""
    if path.exists() or path.is_symlink():
        path.unlink()
    thing = rng.choice(THINGS)
    thing(path)
    return thing.__name__
