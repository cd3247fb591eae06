#!/usr/bin/env python3
"""Checks that every kernel of every ARM table has a line in a baseline, so that its growth is noticed.

    every_kernel_counted.py KERNELS_FOLDER BASELINES_FOLDER

The float kernels are those of kernels.inc. The kernels of bytes are the members of Int8Kernels, each for NEON, SDOT and SMMLA.
"""

import pathlib
import re
import sys

AT_START = {"pack_layer"}  # runs once when a file is opened, in no frame


def lines_of(folder, pattern):
    """The first word of every line of the baselines that match."""
    files = sorted(folder.glob(pattern))
    return {line.split(" ")[1] for file in files for line in file.read_text().splitlines()[1:]}


def main():
    kernels, baselines = map(pathlib.Path, sys.argv[1:])
    floats = re.findall(r"^SANDGLASS_KERNEL\(\w+, (\w+),", (kernels / "kernels.inc").read_text(), re.MULTILINE)
    table = re.search(r"struct Int8Kernels \{(.*?)\n\};", (kernels / "int8.h").read_text(), re.DOTALL)
    of_bytes = [name for name in re.findall(r"\(\*(\w+)\)\(", table[1] if table else "") if name not in AT_START]
    if not floats or not of_bytes:
        sys.exit(f"no kernels found in {kernels}/kernels.inc and int8.h: were they moved?")
    wanted = {"counts_kernels.txt": floats}
    for isa in ("neon", "dotprod", "i8mm"):
        wanted[f"counts_*_{isa}.txt"] = of_bytes
    missing = [f"{name} ({pattern})" for pattern, names in wanted.items() for name in names if name not in lines_of(baselines, pattern)]
    if missing:
        sys.exit("kernels without a counted line: " + ", ".join(missing))
    print(f"{len(floats)} float kernels and {len(of_bytes)} of bytes, for three instruction sets, are counted")


if __name__ == "__main__":
    main()
