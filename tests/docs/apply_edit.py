#!/usr/bin/env python3
"""Makes the edits of a page in a file, as a reader makes them by hand.

usage: apply_edit.py FILE <EDIT

EDIT is a diff without line numbers: lines begin with a blank (they stand in the file), with - (they go) or
with + (they come); a line @@ separates edits. What stands in the file must be there exactly once.
"""
import sys


def edits(text):
    """Of each edit what there was and what there shall be."""
    old, new = [], []
    for line in text.splitlines() + ["@@"]:
        if line == "@@":
            if old or new:
                yield old, new
            old, new = [], []
        elif line[:1] in (" ", "-", "+", ""):
            if line[:1] != "+":
                old.append(line[1:])
            if line[:1] != "-":
                new.append(line[1:])
        else:
            sys.exit(f"not a line of a diff: {line}")


def main():
    path = sys.argv[1]
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    for old, new in edits(sys.stdin.read()):
        at = [i for i in range(len(lines)) if lines[i:i + len(old)] == old]
        if not old or len(at) != 1:
            sys.exit(f"{path} has {len(at)} places like this:\n" + "\n".join(old))
        lines[at[0]:at[0] + len(old)] = new
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")


main()
