#!/usr/bin/env python3
"""ARM instructions of each kind of work unit, for `sandglass run --as` and `sandglass budget`, against the committed ones.

    count_units.py --emulator COMMAND --plugin FILE --program COMMAND --compiler TEXT --table FILE [--write]

Each kind is fitted as instructions = base + per_item * items over its units. Fails when a kind's mean is off the table by more than
5 %. The numbers belong to one compiler; with another the table is printed and the test is skipped (exit code 77). --write replaces
the table: do so after a change to a kernel or to what a unit does.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ALLOWED = 0.05
# What is no work unit.
IGNORED = {"app"}


def measure(arguments):
    """For each name the pairs (items, instructions)."""
    with tempfile.TemporaryDirectory() as folder:
        counts = pathlib.Path(folder) / "counts"
        command = [*arguments.emulator.split(" "), "-plugin", f"{arguments.plugin},out={counts}", *arguments.program.split(" ")]
        printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
        laps = [int(line.split(" ")[0]) for line in pathlib.Path(f"{counts}.laps").read_text().splitlines()]
    if len(laps) != len(printed):
        sys.exit(f"{len(laps)} laps, but {len(printed)} units: was the program built with symbols?")
    units = {}
    for line, instructions in zip(printed, laps):
        items, name = line.split(" ", 1)
        if name not in IGNORED:
            units.setdefault(name, []).append((int(items), instructions))
    return units


def fit(pairs):
    """(base, per item), by least squares; neither is below 0. A kind whose items hardly vary has only the second."""
    n = len(pairs)
    mean_x, mean_y = sum(x for x, _ in pairs) / n, sum(y for _, y in pairs) / n
    spread = sum((x - mean_x) ** 2 for x, _ in pairs)
    if mean_x == 0:
        return mean_y, 0.0
    if spread <= n * (0.1 * mean_x) ** 2:
        return 0.0, mean_y / mean_x
    slope = sum((x - mean_x) * (y - mean_y) for x, y in pairs) / spread
    base = mean_y - slope * mean_x
    if slope < 0:
        return mean_y, 0.0
    return (base, slope) if base >= 0 else (0.0, mean_y / mean_x)


def read(path):
    rows = re.findall(r'\{"([^"]+)", ([0-9.]+), ([0-9.]+)\},', path.read_text())
    return {name: (float(base), float(per_item)) for name, base, per_item in rows}


def main():
    parser = argparse.ArgumentParser()
    for name in ("emulator", "plugin", "program", "compiler", "table"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    units, path = measure(arguments), pathlib.Path(arguments.table)
    if arguments.write:
        rows = [(name, *fit(pairs)) for name, pairs in sorted(units.items())]
        path.write_text(
            "// Executed NEON instructions of a work unit: its name, what it costs at least, and what each of its items adds.\n"
            "// Written by the target count_baseline (tests/bench/count_units.py).\n"
            f"// compiler {arguments.compiler}\n" + "".join(f'{{"{n}", {b:.1f}, {p:.2f}}},\n' for n, b, p in rows)
        )
    table, off = read(path), []
    for name, pairs in sorted(units.items()):
        base, per_item = table.get(name, (0, 0))
        counted, told = sum(y for _, y in pairs), sum(base + per_item * x for x, _ in pairs)
        print(
            f"{counted / len(pairs):14.1f}  {name}, a unit of {sum(x for x, _ in pairs) / len(pairs):.1f} items "
            f"({100 * (told / counted - 1):+.2f} % by the table)"
        )
        if abs(told - counted) > ALLOWED * counted:
            off.append(name)
    if f"// compiler {arguments.compiler}" not in path.read_text():
        print("the table is of another compiler: not gated")
        sys.exit(77)
    if off or table.keys() != units.keys():
        different = ", ".join(sorted({*off, *(table.keys() ^ units.keys())}))
        sys.exit(f"{path.name} is not true any more ({different}): build count_baseline and commit what it writes")


if __name__ == "__main__":
    main()
