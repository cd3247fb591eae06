#!/usr/bin/env python3
"""Ranks the inner loops of an object by llvm-mca: predicted cycles an iteration on three cores, beside the instructions.

    rank_loops.py OBJECT FUNCTION [--objdump aarch64-linux-gnu-objdump] [--mca llvm-mca-19]

An inner loop is the straight run of instructions from the target of a backward branch to that branch. Use the predictions to choose
between two versions of a loop, never as a time: they have been 0.45 to 1.7 times the truth, several ARM names share one model, and
branches inside a loop count as not taken. If the object lacks the function, the function has no such loop, or a tool fails, the
program ends with a sentence and exit code 2.
"""
import argparse
import re
import subprocess
import sys

CORES = ["cortex-a55", "cortex-a76", "neoverse-v2"]  # little; big of 2018; the nearest model to a Cortex-X3
ITERATIONS = 100
SHORTEST = 8  # instructions; shorter loops are copies


def refuse(sentence):
    print(f"rank_loops.py: {sentence}", file=sys.stderr)
    sys.exit(2)


def said_by(command, **options):
    """What the tool prints."""
    try:
        ran = subprocess.run(command, capture_output=True, text=True, **options)
    except OSError as error:
        refuse(f"cannot run {command[0]}: {error.strerror}")
    if ran.returncode != 0:
        refuse(f"{command[0]} failed: {(ran.stderr.strip() or 'without a word').splitlines()[0]}")
    return ran.stdout


def instructions(arguments):
    text = said_by([arguments.objdump, "-d", "--no-show-raw-insn", "-C", arguments.object])
    inside = False
    for line in text.splitlines():
        if line.endswith(">:"):
            inside = arguments.function in line
        match = re.match(r"\s+([0-9a-f]+):\s+(.*)", line)
        if inside and match:
            yield int(match[1], 16), match[2].split("//")[0].strip()


def inner_loops(code):
    """(first, last) indices of loops that contain no other."""
    position = {address: i for i, (address, _) in enumerate(code)}
    loops = []
    for i, (address, text) in enumerate(code):
        match = re.match(r"(?:b\.\w+|cbn?z \w+,|tbn?z .*,|b)\s+([0-9a-f]+) <", text)
        target = int(match[1], 16) if match else None
        if target is not None and target <= address and target in position:
            loops.append((position[target], i))
    return [a for a in loops if not any(b != a and a[0] <= b[0] and b[1] <= a[1] for b in loops)]


def cycles(arguments, body, core):
    # Branches become no-operations, because one pass straight through the loop is modelled.
    lines = [re.sub(r"^(b\.\w+|cbn?z|tbn?z|b|bl)\s.*", "nop", re.sub(r"<[^>]*>", "", text)) for _, text in body]
    lines = [re.sub(r"^(adrp\s+\w+,).*", r"\1 0", text) for text in lines]
    command = [arguments.mca, "--mtriple=aarch64", f"--mcpu={core}", f"--iterations={ITERATIONS}", "--resource-pressure=false",
               "--instruction-info=false"]
    match = re.search(r"Total Cycles:\s+(\d+)", said_by(command, input="\n".join(lines)))
    if not match:
        refuse(f"{arguments.mca} says nothing of cycles for {core}")
    return int(match[1]) / ITERATIONS


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("object")
    parser.add_argument("function")
    parser.add_argument("--objdump", default="aarch64-linux-gnu-objdump")
    parser.add_argument("--mca", default="llvm-mca-19")
    arguments = parser.parse_args()
    code = list(instructions(arguments))
    if not code:
        refuse(f"{arguments.object} has no function '{arguments.function}'; names are as c++filt prints them")
    loops = [code[first:last + 1] for first, last in inner_loops(code) if last + 1 - first >= SHORTEST]
    if not loops:
        refuse(f"'{arguments.function}' has no inner loop of {SHORTEST} instructions or more")
    print(f"{'at':>8} {'instructions':>13} " + " ".join(f"{core:>12}" for core in CORES) + "   cycles an iteration")
    for body in loops:
        predicted = " ".join(f"{cycles(arguments, body, core):12.1f}" for core in CORES)
        print(f"{body[0][0]:8x} {len(body):13d} {predicted}")


if __name__ == "__main__":
    main()
