#!/usr/bin/env python3
"""The most stack that a call can need, from the files that gcc wrote beside the objects (-fstack-usage -fcallgraph-info=su).

    stack_bound.py BUILD_FOLDER --from FUNCTION --limit BYTES

Walks the call graph of every .ci file under the folder and prints the deepest path. Fails above the limit, on recursion, on a
frame of unbounded size, and on a function that the graph does not know.

A call through a pointer is taken to reach any function that is never called by name: so stages, pool tasks and kernels are
entered. Such calls nest at most three deep: governor -> stage, stage -> pool task, task -> kernel. The bound is therefore too high
rather than too low. It leaves out the app's own hooks and the C library's memory functions.
"""

import argparse
import pathlib
import re
import sys

INDIRECT = "__indirect_call"
NESTED_INDIRECT_CALLS = 3
RETURN_ADDRESS_AND_ALIGNMENT = 16  # bytes a call adds beyond the frame that gcc reports

NODE = re.compile(r'node: \{ title: "([^"]+)" label: "([^"]*)"')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')
FRAME = re.compile(r"\\n(\d+) bytes \(([^)]*)\)")


def read_graph(folder):
    frames, names, calls = {}, {}, {}
    for path in sorted(pathlib.Path(folder).rglob("*.ci")):
        text = path.read_text()
        for title, label in NODE.findall(text):
            frame = FRAME.search(label)
            if frame is None:  # only declared here
                continue
            if frame[2] not in ("static", "dynamic,bounded"):
                sys.exit(f"{title}: a frame of unbounded size ({frame[2]})")
            frames[title] = max(frames.get(title, 0), int(frame[1]))
            names[title] = label.split("\\n")[0]
        for source, target in EDGE.findall(text):
            calls.setdefault(source, set()).add(target)
    return frames, names, calls


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder")
    parser.add_argument("--from", dest="start", required=True)
    parser.add_argument("--limit", type=int, required=True)
    arguments = parser.parse_args()

    frames, names, calls = read_graph(arguments.folder)
    if arguments.start not in frames:
        sys.exit(f"{arguments.start} is not in the call graph under {arguments.folder}")
    called_by_name = {target for targets in calls.values() for target in targets}
    by_pointer = [f for f in frames if f not in called_by_name and not f.startswith("sandglass_")]

    known, open_calls = {}, []

    def deepest(function, indirect_left):
        """(bytes, path) of the deepest call chain that starts in `function`."""
        key = (function, indirect_left)
        if key in known:
            return known[key]
        if key in open_calls:
            sys.exit("recursion: " + " -> ".join(names[f] for f, _ in open_calls[open_calls.index(key) :] + [key]))
        open_calls.append(key)
        best = (0, ())
        for target in sorted(calls.get(function, ())):
            if target == INDIRECT:
                reached = [deepest(f, indirect_left - 1) for f in by_pointer] if indirect_left > 0 else []
            else:
                reached = [deepest(target, indirect_left)] if target in frames else []
            best = max([best, *reached])
        open_calls.pop()
        known[key] = (best[0] + frames[function] + RETURN_ADDRESS_AND_ALIGNMENT, (function, *best[1]))
        return known[key]

    total, path = deepest(arguments.start, NESTED_INDIRECT_CALLS)
    for function in path:
        print(f"{frames[function]:8d}  {names[function]}")
    print(f"{total} bytes of stack from {arguments.start}, {len(frames)} functions looked at; limit {arguments.limit}")
    if total > arguments.limit:
        sys.exit("above the limit")


if __name__ == "__main__":
    main()
