#!/usr/bin/env python3
"""Reads a recording of SOMAS with h5py and pandas (Debian: python3-h5py, python3-pandas).

usage: read_recording.py FILE.h5
"""
import sys

import h5py
import pandas as pd


def texts(dataset):
    """A list of texts."""
    return list(dataset.asstr()[:])


def table(group, *columns):
    """Columns of one length as a data frame."""
    return pd.DataFrame({name: group[name][:] for name in columns})


with h5py.File(sys.argv[1], "r") as f:
    states = texts(f["states/name"])
    causes = texts(f["names/causes"])
    kinds = texts(f["names/events"])
    print(f"{f.attrs['experiment']}, generation {f.attrs['generation']}, "
          f"individual {f.attrs['individual']}: {f.attrs['steps']} steps")

    # A row per cell and frame. With one organism, a state's number is its place in states/name.
    cells = table(f["cells"], "step", "id", "state", "x", "y", "energy", "ambrosia")
    last = cells[cells.step == cells.step.max()]
    print(f"\ncells and mean energy at step {cells.step.max()}")
    for state, group in last.groupby("state"):
        print(f"  {states[state]}: {len(group)} {group.energy.mean():.4f}")

    # What happened, at any step.
    events = table(f["events"], "step", "kind", "cell", "cause")
    print("\nevents")
    for kind, name in enumerate(kinds):
        print(f"  {name}: {(events.kind == kind).sum()}")
    print("\ndeaths by cause")
    for cause, count in events[events.kind == kinds.index("death")].cause.value_counts(
            sort=False).sort_index().items():
        print(f"  {causes[cause] if cause < len(causes) else 'wound'}: {count}")

    # Ambrosia that passed between states, over the whole life.
    flux = table(f["flux"], "from_state", "to_state", "amount")
    print("\nambrosia passed on")
    for (giver, receiver), amount in flux.groupby(["from_state", "to_state"]).amount.sum().items():
        print(f"  {states[giver]} -> {states[receiver]}: {amount:.3f}")

    # A grid: frames x rows x columns.
    for name in texts(f["names/grids"]):
        content = f["grids"][name]["content"]
        print(f"\n{name}: {content.shape[1]} x {content.shape[2]} squares, "
              f"{content[-1].mean():.4f} on average at step {f['grids/step'][-1]}")
