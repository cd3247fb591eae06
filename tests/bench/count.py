#!/usr/bin/env python3
"""Executed ARM instructions per item and per frame, against the committed ones.

    count.py sand|kernels|shadow|pile|sky|light|relief|rest|room --emulator COMMAND --plugin FILE --program COMMAND --compiler TEXT --baseline FILE [--write] [--control]

Runs the workload under the emulator with count_plugin, prints the table, and fails when a line has grown by more than 2 %. The
numbers belong to one compiler; with another the table is printed and the test is skipped (exit code 77). --write replaces the
baseline: a change that is meant to cost more says why in its message. --control gates against a baseline lowered by 5 %. The lines
of `kernels`, `relief`, `rest` and `room` are the workloads that the program lists, each run by itself; every_kernel_counted.py looks for a line of each
kernel. What an image may cost a frame, and what a relief may cost more than a plane, are limits of their own.
"""

import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

GROWTH_ALLOWED = 1.02

# Suites whose program lists its workloads, and the functions that count (None: all).
NAMED = {"kernels": r"sandglass::simd_", "relief": None, "rest": None, "room": None}
MOST = {"image_told per item": 1e6, "image_untold per item": 1e6}  # instructions
# Times another line.
TIMES = {"pour_on_relief per item": (1.2, "pour_on_plane per item")}

# metric, the functions it sums up (None: all), and the number printed by the workload that it is divided by
METRICS = {
    "sand": [
        (
            "contacts per particle and sub-step",
            r"::(predict_motion|contact_pairs|solve_touching<\w+>|complete_motion)\(",
            "particle_iterations",
        ),
        ("neighbour_lists per particle and build", r"::(neighbour_lists|find_ranges)\(", "particle_builds"),
        (
            "colours and slack per particle and build",
            r"::(pair_colours_run|colour_class|neighbours_run_measuring|list_slack_run|gather_row|measure_row)\(",
            "particle_builds",
        ),
        ("refine_grains per grain and sweep", r"::refine_grains\(", "grain_sweeps"),
        ("scatter_motion and join per particle and sweep", r"::scatter_motion\(|::motion_join\(", "particle_sweeps"),
        ("count_grains and smooth per grain and sweep", r"::count_grains\(|::motion_smooth\(", "grain_sweeps"),
        ("output per grain", r"::output_run\(", "grains_written"),
        ("whole frame, 60 Hz", None, "frames"),
    ],
    "sand_fine": [
        ("refine_grains per grain and sweep, 100000 grains", r"::refine_grains\(", "grain_sweeps"),
        ("whole frame, 100000 grains", None, "frames"),
    ],
    "shadow": [
        ("shadow_texels per texel", r"sandglass::int8_(?!.*::ambient_texels\()", "texels"),
        ("shadow_texels per thousand multiply-adds", r"sandglass::int8_(?!.*::ambient_texels\()", "thousand_macs"),
        ("ambient_texels per texel", r"sandglass::int8_.*::ambient_texels\(", "ambient_texels"),
        ("whole ambient texture", r"::ambient_texels\(|::ambient_run\(", "textures"),
        ("whole texture", None, "textures"),
    ],
    "pile": [
        ("pile_light per texel", r"::pile_light\(", "texels"),
        ("columns per grain", r"::columns_(run|begin)\(|::put_sphere\(", "grains_put"),
        ("whole texture", None, "textures"),
    ],
    "sky": [
        ("pile_sky per texel", r"::pile_sky\(", "texels"),
        ("levels and rows per texel", r"sandglass::sky_run|::join", "texels"),
        ("whole texture", None, "textures"),
    ],
    "cast": [("whole texture of 2,000 triangles", None, "textures"), ("work unit", None, "units")],
    "light": [
        ("stem per thousand multiply-adds", r"sandglass::int8_[a-z0-9_]+::stem\(", "stem_thousand_macs"),
        ("pool per thousand bytes compared", r"sandglass::int8_[a-z0-9_]+::pool\(", "pool_thousand_bytes"),
        ("narrow (1x1) per thousand multiply-adds", r"sandglass::int8_[a-z0-9_]+::narrow\(", "narrow_thousand_macs"),
        ("wide (3x3) per thousand multiply-adds", r"sandglass::int8_[a-z0-9_]+::wide\(", "wide_thousand_macs"),
        ("transition per thousand multiply-adds", r"sandglass::int8_[a-z0-9_]+::transition\(", "transition_thousand_macs"),
        ("dot per thousand multiply-adds", r"sandglass::int8_[a-z0-9_]+::dot\(", "dot_thousand_macs"),
        ("all per thousand multiply-adds", None, "thousand_macs"),
        ("whole pass", None, "passes"),
    ],
}


# More workloads of a suite, and the program's arguments for them.
MORE = {"sand": {"sand_fine": ("0", "6", "4", "16667", "100000")}}


def command_of(arguments, *more):
    return [*arguments.emulator.split(" "), *more, *arguments.program.split(" ")]


def run(arguments, *workload):
    with tempfile.TemporaryDirectory() as folder:
        counts_file = pathlib.Path(folder) / "counts"
        command = command_of(arguments, "-plugin", f"{arguments.plugin},out={counts_file}")
        printed = subprocess.run([*command, *workload], check=True, capture_output=True, text=True).stdout
        counts = counts_file.read_text()
    names = subprocess.run(["c++filt"], input=counts, check=True, capture_output=True, text=True).stdout
    functions = [(int(line.split(" ", 1)[0]), line.split(" ", 1)[1]) for line in names.splitlines()]
    items = dict(line.split(" ", 1) for line in printed.splitlines())
    if "grains" in items:
        items["grains_written"] = int(items["grains"]) * int(items["frames"])
    return functions, items


def measure(arguments):
    """Instructions an item by metric, and the instruction set of the kernels."""
    if arguments.suite in NAMED:
        names = subprocess.run(command_of(arguments), check=True, capture_output=True, text=True).stdout.split()
        runs = {name: (*run(arguments, name), [(f"{name} per item", NAMED[arguments.suite], "items")]) for name in names}
    else:
        runs = {arguments.suite: (*run(arguments), METRICS[arguments.suite])}
        for name, workload in MORE.get(arguments.suite, {}).items():
            runs[name] = (*run(arguments, *workload), METRICS[name])
    measured = {}
    for functions, items, metrics in runs.values():
        for metric, pattern, divisor in metrics:
            total = sum(count for count, name in functions if pattern is None or re.search(pattern, name))
            if total == 0:
                sys.exit(f"no function matches {pattern}: the workload was built without symbols")
            measured[metric] = total / int(items[divisor])
    return measured, items["isa"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("suite", choices=[*(METRICS.keys() - {"sand_fine"}), *NAMED])
    for name in ("emulator", "plugin", "program", "compiler", "baseline"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--control", action="store_true")
    arguments = parser.parse_args()

    measured, isa = measure(arguments)
    baseline_path = pathlib.Path(arguments.baseline)
    if arguments.write:
        lines = [f"compiler {arguments.compiler}"] + [f"{value:.1f} {metric}" for metric, value in measured.items()]
        baseline_path.write_text("\n".join(lines) + "\n")
    first, *lines = baseline_path.read_text().splitlines()
    baseline = {line.split(" ", 1)[1]: float(line.split(" ", 1)[0]) for line in lines}

    print(f"{arguments.suite}, {isa} kernels, {arguments.compiler}")
    if baseline.keys() != measured.keys():
        different = ", ".join(sorted(baseline.keys() ^ measured.keys()))
        sys.exit(f"{baseline_path.name} has other lines ({different}): build count_baseline and commit what it writes")
    grown = []
    for metric, value in measured.items():
        limit = baseline[metric] * (0.95 if arguments.control else GROWTH_ALLOWED)
        print(f"{value:14.1f}  {metric}  ({100 * (value / baseline[metric] - 1):+.2f} %)")
        if metric in TIMES:
            times, other = TIMES[metric]
            limit = min(limit, times * measured[other])
        if value > min(limit, MOST.get(metric, limit)):
            grown.append(metric)
    if first != f"compiler {arguments.compiler}":
        print(f"the baseline is of another compiler ({first}): not gated")
        sys.exit(77)
    if grown:
        sys.exit("grown beyond the limit: " + ", ".join(grown))


if __name__ == "__main__":
    main()
