#!/usr/bin/env python3
"""Reads the cells of a recording as the replay page names them, or alters one of them.

usage: recorded_cells.py FILE read STEP...
       recorded_cells.py FILE alter STEP ORGANISM CELL COLUMN

`read` prints JSON: for every step its cells (by column; null: not a number), the live cells by
state and the deaths so far by cause. `alter` changes one value as little as possible, in the file.
"""

import json
import sys

import h5py
import numpy


def texts(data_set):
    return list(data_set.asstr()[:])


class Column:
    """A column of the page's table of cells: where it stands in the file, and what numbers mean."""

    def __init__(self, data_set, channel=None, names=None):
        self.data_set, self.channel, self.names = data_set, channel, names

    def place(self, rows):
        return rows if self.channel is None else (rows, self.channel)

    def values(self, rows):
        """JSON can tell."""
        numbers = self.data_set[self.place(slice(rows.start, rows.stop))]
        if self.names is not None:
            return [self.names[number] for number in numbers]
        if numbers.dtype.kind == "f":
            return [None if numpy.isnan(number) else float(number) for number in numbers]
        return [int(number) for number in numbers]

    def alter(self, row):
        old = self.data_set[self.place(row)]
        if self.names is not None:
            new = (old + 1) % len(self.names)
        elif not isinstance(old, numpy.floating):
            new = old + 1
        else:
            new = numpy.float32(0.5) if numpy.isnan(old) else numpy.nextafter(old, numpy.float32(9e9))
        self.data_set[self.place(row)] = new


def columns_of(file):
    """Of a recording with one organism."""
    cells, names = file["cells"], file["names"]
    columns = {"organism": Column(cells["organism"])}
    for shown, stored in (("cell", "id"), ("mother", "parent"), ("born", "born")):
        columns[shown] = Column(cells[stored])
    columns["state"] = Column(cells["state"], names=texts(file["states/name"]))
    columns["action"] = Column(cells["action"], names=texts(names["actions"]))
    for name in ("x", "y", "radius", "energy", "ambrosia", "pressure"):
        columns[name] = Column(cells[name])
    for name in texts(names["hazards"]):
        columns["damage " + name] = Column(cells["damage." + name])
    for name in texts(names["values"]):
        columns[name] = Column(cells["value." + name])
    for channel, name in enumerate(texts(names["inputs"])):
        columns["sensed " + name] = Column(cells["inputs"], channel)
    for channel, name in enumerate(texts(file["organisms/outputs.0"])):
        columns["output " + name] = Column(cells["outputs"], channel)
    return columns


def rows_of(file, step):
    frame = list(file["frames/step"][:]).index(step)
    first = int(file["frames/first_cell"][frame])
    return range(first, first + int(file["frames/cells"][frame]))


def deaths_until(file, step):
    events = file["events"]
    kinds, causes = texts(file["names/events"]), texts(file["names/causes"])
    died = (events["kind"][:] == kinds.index("death")) & (events["step"][:] <= step)
    numbers, counts = numpy.unique(events["cause"][:][died], return_counts=True)
    return {causes[n] if n < len(causes) else "wound": int(c) for n, c in zip(numbers, counts)}


def read(file, step):
    columns, rows = columns_of(file), rows_of(file, step)
    shown = {name: column.values(rows) for name, column in columns.items()}
    return {
        "step": step,
        "columns": shown,
        "population": {state: shown["state"].count(state) for state in columns["state"].names},
        "deaths": deaths_until(file, step),
    }


def alter(file, step, organism, cell, name):
    columns, rows = columns_of(file), rows_of(file, step)
    living = list(zip(columns["organism"].values(rows), columns["cell"].values(rows)))
    if (organism, cell) not in living:
        sys.exit(f"there is no cell {cell} of organism {organism} at step {step}")
    columns[name].alter(rows[living.index((organism, cell))])


def main():
    path, what, *rest = sys.argv[1:]
    with h5py.File(path, "r+" if what == "alter" else "r") as file:
        if what == "read":
            json.dump([read(file, int(step)) for step in rest], sys.stdout)
        else:
            step, organism, cell, name = rest
            alter(file, int(step), int(organism), int(cell), name)


main()
