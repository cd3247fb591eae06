#!/usr/bin/env python3
"""Executed ARM instructions per shadow texture: NEON, SDOT and SMMLA tables, all texels and adaptive.

    count_shadow.py --emulator "qemu-aarch64 -L DIR" --plugin FILE --program FILE --asset FILE --compiler TEXT --baseline FILE [--write]

Fails when a line has grown by more than 2 % over the committed baseline; with another compiler than the baseline's the table is
printed and the test is skipped (exit code 77). --write replaces the baseline.
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

GROWTH_ALLOWED = 1.02
TABLES = {"neon": 2, "neon_dotprod": 5, "neon_i8mm": 6}  # numbers of sandglass_isa
MODES = ("full", "adaptive")


def count(arguments, isa, mode):
    with tempfile.TemporaryDirectory() as folder:
        counts = pathlib.Path(folder) / "counts"
        command = [*arguments.emulator.split(" "), "-cpu", "max", "-plugin", f"{arguments.plugin},out={counts}",
                   arguments.program, arguments.asset, str(isa), mode]
        printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        return sum(int(line.split(" ", 1)[0]) for line in counts.read_text().splitlines()), int(printed.split()[1])


def main():
    parser = argparse.ArgumentParser()
    for name in ("emulator", "plugin", "program", "asset", "compiler", "baseline"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()

    measured = {f"{table} {mode}": count(arguments, isa, mode) for table, isa in TABLES.items() for mode in MODES}
    path = pathlib.Path(arguments.baseline)
    if arguments.write:
        path.write_text(f"compiler {arguments.compiler}\n" + "".join(f"{n} {name}\n" for name, (n, _) in measured.items()))
    first, *lines = path.read_text().splitlines()
    baseline = {line.split(" ", 1)[1]: int(line.split(" ", 1)[0]) for line in lines}
    grown = []
    for name, (instructions, texels) in measured.items():
        print(f"{instructions / 1e6:10.2f} M instructions a texture, {instructions / texels:8.1f} a texel asked for: {name} "
              f"({100 * (instructions / baseline[name] - 1):+.2f} %)")
        if instructions > GROWTH_ALLOWED * baseline[name]:
            grown.append(name)
    if first != f"compiler {arguments.compiler}":
        print(f"the baseline is of another compiler ({first}): not gated")
        sys.exit(77)
    if grown:
        sys.exit("grown beyond the limit: " + ", ".join(grown))


if __name__ == "__main__":
    main()
