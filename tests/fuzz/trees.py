"""Plain data (texts, numbers, lists, tables) with some of it exchanged."""

import copy
import json

from values import DATA, HOSTILE, expression

MOST_EDITS = 8
MOST_DEPTH = 150
"""What Python's own JSON still writes."""


def places(tree, path=()):
    """Keys that lead to every entry of a tree, in order; without the root."""
    found = []
    waiting = [(tree, path)]
    while waiting:
        part, here = waiting.pop()
        inner = part.items() if isinstance(part, dict) else enumerate(part) if isinstance(part, list) else ()
        for key, value in inner:
            found.append((*here, key))
            waiting.append((value, (*here, key)))
    return found


def at(tree, path):
    """The entry to which keys lead."""
    for key in path:
        tree = tree[key]
    return tree


def value(chance):
    """Anything."""
    if chance.random() < 0.3:
        return chance.choice(HOSTILE)
    if chance.random() < 0.1:
        return nested(chance.choice([3, 40, MOST_DEPTH - 30]), chance)
    return copy.deepcopy(chance.choice(DATA))


def nested(depth, chance):
    """Lists or tables in each other."""
    found = 1
    for _ in range(depth):
        found = [found] if chance.random() < 0.5 else {"a": found}
    return found


def mutated(tree, chance, other=None):
    """A changed copy.

    ``other`` is a tree of the same kind, parts of which may be taken over.
    """
    tree = copy.deepcopy(tree)
    for _ in range(chance.choice([1, 1, 1, 2, 3, 6])):
        found = places(tree)
        if not found:
            return tree
        path = chance.choice(found)
        if len(path) > MOST_DEPTH:
            continue
        holder, key = at(tree, path[:-1]), path[-1]
        _change(holder, key, chance, other, tree)
    return tree


def _change(holder, key, chance, other, tree):
    old = holder[key]
    way = chance.randrange(9)
    if way <= 1 and isinstance(old, str):
        holder[key] = expression(old, chance)
    elif way <= 2:
        holder[key] = value(chance)
    elif way == 3:
        del holder[key]
    elif way == 4 and isinstance(holder, dict):
        name = chance.choice([chance.choice(HOSTILE), str(key)[::-1], "", f"{key}_2", chance.choice(list(holder))])
        holder[name] = holder.pop(key)
    elif way == 4:
        holder.insert(chance.randrange(len(holder) + 1), copy.deepcopy(old))
    elif way == 5:
        taken = chance.choice(places(tree))
        if not isinstance(at(tree, taken), dict | list):
            holder[key] = at(tree, taken)
    elif way == 6 and other is not None and (found := places(other)):
        holder[key] = copy.deepcopy(at(other, chance.choice(found)))
    elif way == 7 and isinstance(old, int | float) and not isinstance(old, bool):
        holder[key] = chance.choice([-old, old + 1, old * 2, old / 3, float(old), str(old), [old]])
    elif isinstance(holder, dict):
        holder[chance.choice(["x", "v", "name", "kind", *map(str, holder)])] = value(chance)
    else:
        holder.append(value(chance))


def edited(edits, chance, others, draw):
    """A list of edits with one more, one less, or another value in one.

    Parameters
    ----------
    edits, others : list of dict
        The list, and another one from which an edit may be taken over.
    chance : random.Random
    draw : callable
        Gives a new edit.
    """
    way = chance.randrange(8)
    if way == 0 and edits:
        edits.pop(chance.randrange(len(edits)))
    elif way == 1 and others:
        edits.append(chance.choice(others))
    elif way == 2 and edits:
        entry = chance.choice(edits)
        changeable = [key for key in entry if key not in ("way", "file")]
        if changeable:
            entry[chance.choice(changeable)] = copy.deepcopy(chance.choice(DATA))
    else:
        edits.append(draw())
    return edits[-MOST_EDITS:]


def written(tree, indent=None):
    """The tree as an input."""
    return json.dumps(tree, indent=indent).encode()
