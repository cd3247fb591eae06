"""The pages' numbers: measured by one command each, kept as JSON, shown between marks.

numbers.py check ROOT           fails where a page shows another number than the JSON, or a table has a number of nobody
numbers.py show ROOT            writes the JSON's numbers into the pages
numbers.py measure ROOT [NAME]  runs measurements (all without a name), writes models/numbers/NAME.json, then shows them

A JSON file holds the command, its conditions, and rows: case, metric, value. Marks are comments without spaces; a space
of a case is an underscore there.
  <!--FILE#CASE#METRIC-->0.71        in a text or a cell: the number that follows
  <!--FILE|COLUMN|COLUMN-->          before a table: what its columns after the first hold
  | name<!--CASE--> | 0.71 | 18 % |  a row of it; a row without a mark holds no measured number
A COLUMN is METRIC, or CASE#METRIC with a * where the row's CASE stands, or FILE!METRIC, or empty; METRIC is `result` where
it is left out, and METRIC@100 or METRIC@/1024 scales. Several numbers of one cell: COLUMN+COLUMN. A number keeps the
decimals that the page gives it. <!--held:TEST--> before a table names the test that holds its numbers itself.
"""
import datetime
import json
import pathlib
import platform
import re
import subprocess
import sys
import tempfile

LAB = 'build/host/bin/sandglass_lab'
PAGES = ['README.md', 'models/RESULTS.md', 'models/lighting/MODEL_CARD.md', 'runtime/README.md', 'runtime/shadow/README.md',
         'models/kit/README.md', 'toolchains/web/README.md']
FULL = {'models/RESULTS.md'}  # every table there has marks
# name: commands without --json. The numbers of a list are averaged; of several objects each has its name before the case.
MEASUREMENTS = {
    'bench_granular': [f'{LAB} bench granular --threads 1,2 --peers'],
    'bench_growth': [f'{LAB} bench growth --threads 1'],
    'bench_shadow': [f'{LAB} bench shadow'],
    'bench_lighting': [f'{LAB} bench lighting'],
    'verify_granular': [f'{LAB} verify granular'],
    'verify_follow': [f'{LAB} verify follow --seed {seed}' for seed in range(4)],
    'verify_lighting': [f'{LAB} verify lighting --threads 2'],
    'verify_room': [f'{LAB} verify room --threads 2'],
    'verify_shot': [f'{LAB} verify shot --threads 2'],
    'verify_cast': [f'{LAB} verify cast --threads 2'],
    'verify_colour': [f'{LAB} verify colour --threads 2'],
    'verify_look': [f'{LAB} verify look --threads 2'],
    'shot_budget': ['build/host/tests/compositing/sandglass_shot_budget_tests'],
    'pile': ['build/host/tests/shadow/sandglass_shadow_tests --gtest_filter=*Pile*'],
    'bakes': {mesh: f'build/host/bin/sandglass bake {mesh.replace(" ", "_")} --threads 2 -o out/numbers.shadow'
              for mesh in ('chair', 'armadillo', 'trefoil knot', 'wicker chair', 'bucket')},
}
NUMBER = r'[-+−]?\d+(?:,\d{3})*(?:\.\d+)?(?:e[-+]?\d+)?'


class Numbers:
    """What the JSON files say, and which faults a page has."""

    def __init__(self, root):
        self.root, self.files, self.faults = root, {}, []

    def rows(self, name):
        if name not in self.files:
            path = self.root / 'models' / 'numbers' / f'{name}.json'
            counts = self.root / 'tests' / 'bench' / f'{name}.txt'
            if path.exists():
                self.files[name] = json.loads(path.read_text())['rows']
            elif counts.exists():  # of ARM: a test holds them to 2 %
                lines = (line.split(' ', 1) for line in counts.read_text().splitlines())
                self.files[name] = {case: {'count': float(value)} for value, case in lines if value[0].isdigit()}
            else:
                self.files[name] = {}
        return {case.replace(' ', '_'): values for case, values in self.files[name].items()}

    def value(self, name, case, metric, where):
        metric, _, scale = metric.partition('@')
        value = self.rows(name).get(case, {}).get(metric)
        if value is None:
            self.faults.append(f'{where}: {name} has no {case}:{metric}')
            return None
        if scale:
            value = value / float(scale[1:]) if scale[0] == '/' else value * float(scale)
        return value


def shown(value, like):
    """A value as the page writes numbers there: as many decimals, a sign, an exponent or commas where it has them."""
    if 'e' in like:
        digits = len(like.split('e')[0].partition('.')[2])
        return re.sub(r'e([-+])0*(\d)', lambda m: 'e' + m[1].replace('+', '') + m[2], f'{value:.{digits}e}')
    decimals = len(like.partition('.')[2])
    text = f'{value:,.{decimals}f}' if ',' in like or abs(value) >= 10000 else f'{value:.{decimals}f}'
    if float(text.replace(',', '')) == 0.0:
        text = text.lstrip('-')
    if text[0] != '-' and (like[0] == '+' or (like[0] == '−' and value > 0)):
        text = '+' + text
    return text.replace('-', '−') if '−' in like else text


def cell_of(numbers, table, case, columns, cell, where):
    """A cell with the measured numbers in place of its first ones."""
    columns = iter(columns.split('+'))

    def next_value(m):
        column = next(columns, None)
        if column is None:
            return m[0]
        name, _, metric = column.rpartition('!')
        row, _, metric = metric.partition('#') if '*' in metric else (case, '', metric)
        value = numbers.value(name or table, row.replace('*', case), metric or 'result', where)
        return m[0] if value is None else shown(value, m[0])

    return re.sub(NUMBER, next_value, cell)


def render(numbers, path, text, full):
    """The page with the JSON's numbers."""
    lines, columns, table, held = text.split('\n'), [], '', False
    for i, line in enumerate(lines):
        where = f'{path}:{i + 1}'

        def marked(m, where=where):
            value = numbers.value(*m[1].split('#'), where)
            return m[0] if value is None else f'<!--{m[1]}-->{m[2]}{shown(value, m[3])}'

        line = re.sub(rf'<!--(\w+#[^\s|#]+#[^\s|#]+)-->(\**)({NUMBER})', marked, line)
        head = re.fullmatch(r'<!--(\w+)((?:\|[^|\s]*)+)-->', line)
        if head:
            table, columns = head[1], head[2][1:].split('|')
        elif line.startswith('<!--held:'):
            held = True
        elif not line.startswith(('|', '<!--')):
            table, held = '', False
        cells = re.split(r'(?<!\\)\|', line)
        row = re.search(r'<!--([^#|\s]+)-->', cells[1]) if line.startswith('|') and table else None
        if row:
            for k, column in enumerate(columns[:len(cells) - 3], 2):
                if column and '<!--' not in cells[k]:
                    cells[k] = cell_of(numbers, table, row[1], column, cells[k], where)
            line = '|'.join(cells)
        elif full and not held and re.match(r'\|(?!---).*\d\.\d', line) and '<!--' not in line and lines[i + 1][:4] != '|---':
            numbers.faults.append(f'{where}: no measurement gives these numbers: {line}')
        lines[i] = line
    return '\n'.join(lines)


def pages(root, write):
    numbers = Numbers(root)
    for page in PAGES:
        path = root / page
        if not path.exists():
            continue
        text = path.read_text()
        fresh = render(numbers, page, text, page in FULL)
        for old, new in zip(text.split('\n'), fresh.split('\n')):
            if old != new and not write:
                numbers.faults.append(f'{page} says\n  {old}\nand the measurement\n  {new}')
        if write and fresh != text:
            path.write_text(fresh)
    for fault in numbers.faults:
        print(fault)
    print(f'{len(numbers.faults)} faults')
    return 1 if numbers.faults else 0


def rows_of(data):
    """The rows of the laboratory's JSON, or what the tests of a gtest JSON recorded."""
    rows = {}
    if isinstance(data, list):
        for m in data:
            row = rows.setdefault(m['case'], {})
            key = m['metric'] if m['threads'] == 1 or m['suite'] in ('lighting', 'room', 'shot', 'colour', 'look') else f"{m['metric']}_{m['threads']}T"
            row[key] = m['value']
            for more in ('truth', 'limit'):
                if m.get(more) is not None:
                    row[more] = m[more]
        return rows
    known = {'name', 'file', 'line', 'status', 'result', 'timestamp', 'time', 'classname', 'value_param', 'failures'}
    for suite in data['testsuites']:
        for test in suite['testsuite']:
            for key, value in test.items():
                if key not in known:
                    case, _, metric = key.rpartition(':')
                    rows.setdefault(case, {})[metric] = float(value)
    return rows


def run(root, command):
    print(f'== {command}', flush=True)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / 'rows.json'
        option = ['--json', str(out)] if 'sandglass_lab' in command or ' bake ' in command else [f'--gtest_output=json:{out}']
        code = subprocess.run(command.split() + option, cwd=root).returncode
        if code not in (0, 1) or not out.exists():
            sys.exit(f'{command} ended with {code} and wrote no numbers')
        return rows_of(json.loads(out.read_text()))


def measure(root, name):
    commands = MEASUREMENTS[name]
    if isinstance(commands, dict):
        rows = {f'{what}: {case}': values for what, command in commands.items() for case, values in run(root, command).items()}
        commands = commands.values()
    else:
        runs = [run(root, command) for command in commands]
        rows = {case: {metric: sum(r[case][metric] for r in runs) / len(runs) for metric in values
                       if all(r.get(case, {}).get(metric) is not None for r in runs)} for case, values in runs[0].items()}
    rows = {case: {metric: float(f'{value:.6g}') for metric, value in values.items() if value is not None} for case, values in rows.items()}
    git = subprocess.run(['git', 'describe', '--always', '--dirty'], cwd=root, capture_output=True, text=True).stdout.strip()
    model = re.search(r'model name\s*: (.*)', pathlib.Path('/proc/cpuinfo').read_text())
    head = {'command': ' ; '.join(commands), 'commit': git, 'date': datetime.date.today().isoformat(),
            'machine': f'{model[1] if model else platform.machine()}, {len(re.findall("^processor", pathlib.Path("/proc/cpuinfo").read_text(), re.M))} cores'}
    lines = [f'  {json.dumps(case)}: {json.dumps(values)}' for case, values in rows.items()]
    text = json.dumps(head, indent=1)[:-2] + ',\n "rows": {\n' + ',\n'.join(lines) + '\n }\n}\n'
    folder = root / 'models' / 'numbers'
    folder.mkdir(exist_ok=True)
    (folder / f'{name}.json').write_text(text)


def main():
    verb, root, names = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3:]
    unknown = [name for name in names if name not in MEASUREMENTS]
    if unknown:
        sys.exit(f'no measurement is called {unknown[0]}: take {", ".join(MEASUREMENTS)}')
    if verb == 'measure':
        for name in names or MEASUREMENTS:
            measure(root, name)
    return pages(root, write=verb != 'check')


if __name__ == '__main__':
    sys.exit(main())
