"""The pages' numbers: measured by one command each, kept as JSON, shown after marks.

numbers.py check ROOT           fails where a page shows another number than the JSON, or a table has a number of nobody
numbers.py show ROOT            writes the JSON's numbers into the pages
numbers.py measure ROOT [NAME]  runs the command of models/numbers/NAME.json (of all without a name), writes and shows its rows

A JSON file holds the command, its conditions, and rows: case, metric, value. A mark is a comment without spaces:
  <!--FILE#CASE#METRIC-->0.71                the number after it in the line is that of the JSON
  <!--FILE#CASE#{METRIC;METRIC}-->0.71 18 %  braces give each part in turn, so many numbers follow; anywhere in a mark
  <!--FILE#CASE#METRIC*100-->                is shown 100 times as large; METRIC/1e6 divided
A space of a case is an underscore in a mark. A number keeps the decimals that the page gives it. All other numbers of a
line are nobody's, which in a table of RESULTS.md is a fault, unless <!--held:TEST--> before it names who holds them.
"""

import datetime
import itertools
import json
import pathlib
import platform
import re
import subprocess
import sys
import tempfile

PAGES = [
    "README.md",
    "models/RESULTS.md",
    "models/lighting/MODEL_CARD.md",
    "runtime/README.md",
    "runtime/shadow/README.md",
    "models/kit/README.md",
    "toolchains/web/README.md",
]
FULL = {"models/RESULTS.md"}  # every table there has marks
MARK = re.compile(r"<!--(\w+#\S+?)-->")
NUMBER = r"(?<![\w.])[-+−]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?"


class Numbers:
    """What the JSON files say, and which faults a page has."""

    def __init__(self, root):
        self.root, self.files, self.faults = root, {}, []

    def rows(self, name):
        if name not in self.files:
            path = self.root / "models" / "numbers" / f"{name}.json"
            counts = self.root / "tests" / "bench" / f"{name}.txt"
            if path.exists():
                self.files[name] = json.loads(path.read_text())["rows"]
            elif counts.exists():  # of ARM: a test holds them to 2 %
                lines = (line.split(" ", 1) for line in counts.read_text().splitlines())
                self.files[name] = {case: {"count": float(value)} for value, case in lines if value[0].isdigit()}
            else:
                self.files[name] = {}
        return {case.replace(" ", "_"): values for case, values in self.files[name].items()}

    def value(self, address, where):
        name, case, metric = (address + "#result").split("#")[:3]
        metric, sign, factor = re.fullmatch(r"([^*/]+)([*/]?)(.*)", metric).groups()
        value = self.rows(name).get(case, {}).get(metric)
        if value is None:
            self.faults.append(f"{where}: {name} has no {case}#{metric}")
        elif sign:
            value = value * float(factor) if sign == "*" else value / float(factor)
        return value


def addresses(mark):
    """FILE#CASE#METRIC of every number of a mark."""
    parts = re.split("[{}]", mark)
    choices = [part.split(";") if k % 2 else [part] for k, part in enumerate(parts)]
    return ["".join(chosen) for chosen in itertools.product(*choices)]


def shown(value, like):
    """A value as the page writes numbers there: as many decimals, a sign, an exponent or commas where it has them."""
    if "e" in like:
        digits = len(like.split("e")[0].partition(".")[2])
        return re.sub(r"e([-+])0*(\d)", lambda m: "e" + m[1].replace("+", "") + m[2], f"{value:.{digits}e}")
    decimals = len(like.partition(".")[2])
    text = f"{value:,.{decimals}f}" if "," in like or abs(value) >= 10000 else f"{value:.{decimals}f}"
    if float(text.replace(",", "")) == 0.0:
        text = text.lstrip("-")
    if text[0] != "-" and (like[0] == "+" or (like[0] == "−" and value > 0)):
        text = "+" + text
    return text.replace("-", "−") if "−" in like else text


def marked(numbers, line, where):
    """The line with the JSON's numbers after its marks."""
    pieces = MARK.split(line)
    for k in range(1, len(pieces), 2):
        values = [numbers.value(address, where) for address in addresses(pieces[k])]
        rest = iter(values)

        def fresh(m, rest=rest):
            value = next(rest)
            return m[0] if value is None else shown(value, m[0])

        pieces[k + 1], count = re.subn(NUMBER, fresh, pieces[k + 1], count=len(values))
        if count < len(values):
            numbers.faults.append(f"{where}: {len(values)} numbers should follow {pieces[k]}, and {count} do")
        pieces[k] = f"<!--{pieces[k]}-->"
    return "".join(pieces)


def render(numbers, path, text, full):
    """The page with the JSON's numbers."""
    lines, held = text.split("\n"), False
    for i, line in enumerate(lines):
        where = f"{path}:{i + 1}"
        held = line.startswith("<!--held:") or (held and line.startswith(("|", "<!--")))
        for comment in re.findall(r"<!--\S.*?-->", line):
            if not MARK.fullmatch(comment) and not comment.startswith("<!--held:"):
                numbers.faults.append(f"{where}: {comment} is no mark")
        if full and not held and re.match(r"\|(?!---).*\d\.\d", line) and "<!--" not in line and lines[i + 1][:4] != "|---":
            numbers.faults.append(f"{where}: no measurement gives these numbers: {line}")
        lines[i] = marked(numbers, line, where)
    return "\n".join(lines)


def pages(root, write):
    numbers = Numbers(root)
    for page in PAGES:
        path = root / page
        if not path.exists():
            continue
        text = path.read_text()
        fresh = render(numbers, page, text, page in FULL)
        for old, new in zip(text.split("\n"), fresh.split("\n")):
            if old != new and not write:
                numbers.faults.append(f"{page} says\n  {old}\nand the measurement\n  {new}")
        if write and fresh != text:
            path.write_text(fresh)
    for fault in numbers.faults:
        print(fault)
    print(f"{len(numbers.faults)} faults")
    return 1 if numbers.faults else 0


def rows_of(data):
    """The rows of the laboratory's JSON, or what the tests of a gtest JSON recorded."""
    rows, threads = {}, {}
    if isinstance(data, list):
        for m in data:
            row = rows.setdefault(m["case"], {})
            first = threads.setdefault((m["case"], m["metric"]), m["threads"])
            row[m["metric"] if m["threads"] == first else f"{m['metric']}_{m['threads']}T"] = m["value"]
            for more in ("truth", "limit"):
                if m.get(more) is not None:
                    row[more] = m[more]
        return rows
    known = {"name", "file", "line", "status", "result", "timestamp", "time", "classname", "value_param", "failures"}
    for suite in data["testsuites"]:
        for test in suite["testsuite"]:
            for key, value in test.items():
                if key not in known:
                    case, _, metric = key.rpartition(":")
                    rows.setdefault(case, {})[metric] = float(value)
    return rows


def run(root, command):
    print(f"== {command}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "rows.json"
        option = [f"--gtest_output=json:{out}"] if "_tests" in command else ["--json", str(out)]
        code = subprocess.run(command.split() + option, cwd=root).returncode
        if code not in (0, 1) or not out.exists():
            sys.exit(f"{command} ended with {code} and wrote no numbers")
        return rows_of(json.loads(out.read_text()))


def measure(root, path, commands):
    """The numbers of commands with ; between them are averaged. Of several objects each has its name before the case."""
    if isinstance(commands, dict):
        rows = {f"{what}: {case}": values for what, command in commands.items() for case, values in run(root, command).items()}
    else:
        runs = [run(root, command) for command in commands.split(" ; ")]
        rows = {
            case: {
                metric: sum(r[case][metric] for r in runs) / len(runs)
                for metric in values
                if all(r.get(case, {}).get(metric) is not None for r in runs)
            }
            for case, values in runs[0].items()
        }
    rows = {case: {metric: float(f"{value:.6g}") for metric, value in values.items() if value is not None} for case, values in rows.items()}
    git = subprocess.run(["git", "describe", "--always", "--dirty"], cwd=root, capture_output=True, text=True).stdout.strip()
    model = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    head = {
        "command": commands,
        "commit": git,
        "date": datetime.date.today().isoformat(),
        "machine": f"{model[1] if model else platform.machine()}, {len(re.findall('^processor', pathlib.Path('/proc/cpuinfo').read_text(), re.M))} cores",
    }
    lines = [f"  {json.dumps(case)}: {json.dumps(values)}" for case, values in rows.items()]
    text = json.dumps(head, indent=1)[:-2] + ',\n "rows": {\n' + ",\n".join(lines) + "\n }\n}\n"
    path.write_text(text)


def main():
    verb, root, names = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3:]
    if verb == "measure":
        folder = root / "models" / "numbers"
        for path in [folder / f"{name}.json" for name in names] or sorted(folder.glob("*.json")):
            if not path.exists():
                sys.exit(f'{path} is missing: write it, {{"command": "build/host/bin/sandglass_lab verify NAME"}}')
            commands = json.loads(path.read_text())["command"]
            if "build/host/" in str(commands):
                measure(root, path, commands)
            else:
                print(f"{path.name} is measured otherwise: {commands}")
    return pages(root, write=verb != "check")


if __name__ == "__main__":
    sys.exit(main())
