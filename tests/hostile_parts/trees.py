"""Damage to the values of a JSON file, and to the file as a whole."""

import copy
import json

from . import instead, raw

WRONG = [None, True, False, 0, -1, 1, 2, 7, 1e308, -1e308, 1e30, 10 ** 30, 2 ** 63, 2 ** 64 - 1, -2 ** 63,
         1000000000000, 0.5, 5e-324, "", "x", "..", "../victim", "/etc/passwd", "a\u0000b", "a\nb", "\u001b[2J",
         "x" * 5000, "y" * 200000, "1/1", "0/0", "monte-carlo", "study", [], {}, [[]], [None], [1, 2], [1, 2, 3],
         [[1, 2, 3]] * 3, [[0, 0, 0]] * 3, ["a"] * 1000, {"a": 1}, {"": {}}, [0] * 200000,
         [{}] * 50000]


def places(tree, path=()):
    """The path of every value below the root."""
    found = []
    items = tree.items() if isinstance(tree, dict) else enumerate(tree)
    for key, value in items:
        found.append(path + (key,))
        if isinstance(value, (dict, list)) and value:
            found += places(value, path + (key,))
    return found


def parent_of(tree, path):
    for key in path[:-1]:
        tree = tree[key]
    return tree


def some_place(rng, tree):
    """Mostly near the root, where the keys have names."""
    found = places(tree)
    near = [path for path in found if len(path) <= 2]
    return rng.choice(near if near and rng.random() < 0.6 else found)


def wrong_value(rng, tree, path):
    value = rng.choice(WRONG)
    parent_of(tree, path)[path[-1]] = value
    return f"= {json.dumps(value)[:30]}"


def other_value(rng, tree, path):
    other = parent_of(tree, path)
    there = some_place(rng, tree)
    other[path[-1]] = copy.deepcopy(parent_of(tree, there)[there[-1]])
    return "= what is at " + "/".join(map(str, there))


def lose(rng, tree, path):
    del parent_of(tree, path)[path[-1]]
    return "lost"


def repeat(rng, tree, path):
    parent = parent_of(tree, path)
    times = rng.choice([2, 10, 1000, 20000])
    value = parent[path[-1]]
    if isinstance(value, list):
        parent[path[-1]] = value * times
    elif isinstance(parent, list):
        parent[:] = parent + [value] * times
    else:
        parent[path[-1]] = [value] * times
    return f"repeated {times} times"


def many_keys(rng, tree, path):
    parent_of(tree, path)[path[-1]] = {f"key {k}": k for k in range(rng.choice([100, 9000, 100000]))}
    return "many keys"


def rename(rng, tree, path):
    parent = parent_of(tree, path)
    if isinstance(parent, dict):
        parent["../" + str(path[-1])] = parent.pop(path[-1])
    return "renamed"


CHANGES = [wrong_value] * 6 + [other_value, other_value, lose, repeat, repeat, many_keys, rename]


def changed(rng, content):
    """The content with another value at a place, and how."""
    tree = json.loads(content)
    if not isinstance(tree, (dict, list)) or not tree:
        return b"[]", "empty"
    path = some_place(rng, tree)
    how = rng.choice(CHANGES)(rng, tree, path)
    return json.dumps(tree).encode(), f"/{'/'.join(map(str, path))} {how}"


def nested(rng, content):
    depth = rng.choice([65, 1000, 150000, 1000000])
    begin, end = rng.choice([(b"[", b"]"), (b'{"a":', b"}"), (b"[{},", b"]"), (b"[", b"")])
    inside = begin * depth + (b"0" if begin.endswith(b":") else b"") + end * depth
    key = rng.choice([b"", b'{"files":', b'{"boresight":', b'{"schema":"dn.report/1","files":'])
    return key + inside + (b"}" if key and end else b""), f"{key.decode()} nested {depth} deep"


def keys_twice(rng, content):
    tree = json.loads(content)
    if not isinstance(tree, dict) or not tree:
        return b'{"a":1,"a":2}', "a key twice"
    key = rng.choice(list(tree))
    text = json.dumps(tree)
    return (text[:-1] + ", " + json.dumps({key: rng.choice(WRONG)})[1:]).encode(), f"key {key} twice"


def wide(rng, content):
    element = rng.choice([b"[],", b"0,", b"{},", b'"",', b'{"a":""},', b"null,"])
    count = rng.choice([100000, 1000000, 4000000])
    return b'{"files":[' + element * count + b"0]}", f"{count} times {element.decode()}"


def no_text(rng, content):
    return rng.choice([b"", b"null", b"0", b'"x"', b"[]", b"{}", b"nan", b"\xff", b"{" * 5, b"1e999"]), "another"


def damaged(rng, content):
    """The content damaged in its values, its shape or its bytes, and how."""
    draw = rng.random()
    if draw < 0.65:
        return changed(rng, content)
    if draw < 0.8:
        return rng.choice([nested, keys_twice, wide, no_text])(rng, content)
    return raw.damaged(rng, content)


def damage(rng, path):
    """Damages a JSON file, or lays something else in its place; says how."""
    if rng.random() < 0.15:
        return instead.laid(rng, path)
    content, how = damaged(rng, path.read_bytes())
    path.write_bytes(content)
    return how
