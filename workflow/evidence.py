#!/usr/bin/env python3
"""Remakes the figures of the documentation, or checks that they are up to date.

A file workflow/evidence/NAME.toml belongs to one page:

  page = "docs/NAME.md"
  [step.STEP]               what is run, and which figures are kept of it
  run = ["./kinegraph ..."] as from the project's root, in a folder of its own
  targets = ["PROGRAM"]     what must be built beside the commands (optional)
  read = {x = "x.json"}     result files; with *, all of them by their names
  figures.F = "EXPRESSION"  in Python, of what was read
  files = {"ablation.svg" = "docs/images/ablation.svg"}   taken over (optional)
  slow = true               takes hours: run by --only alone (optional)
  [table.TABLE]
  rows = "STEP['F']"        in Python, of all steps' figures: a dict a row;
                            shown(VALUE, SPEC), geometric_mean(VALUES),
                            at_most(COUNT, TOTAL),
                            with_sum(ROWS, KEYS, KEY='of the last row', ...)
  columns = [["HEAD", "{KEY:.2f}"], ...]
  [block]
  BLOCK = '''...'''         Markdown with {STEP[F]:.2f}; a figure with an interval
                            or counts prints these too; {table[TABLE]}

Result files are JSON, or JSON Lines where they end in .jsonl; all others are
read as text.

A block stands in its page between <!-- evidence:BLOCK --> and <!-- /evidence -->,
filled with the figures of docs/evidence/STEP.json. Steps may be used by blocks
of other pages.
"""
import argparse
import hashlib
import json
import math
import os
import pathlib
import platform
import re
import shutil
import subprocess
import sys
import time
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
KEPT = ROOT / "docs/evidence"
# What figures come from; a change elsewhere does not make them older.
SOURCES = ["apps", "core", "solvers", "configs", "tests/benchmarks"]


class Failure(Exception):
    pass


class Figure(dict):
    """Prints a value with its interval, or a share with its counts."""

    def __format__(self, spec):
        text = format(self.get("value", self.get("percent")), spec)
        if "interval" in self:
            spec = spec.lstrip("+")
            text += f" [{self['interval']['low']:{spec}}, {self['interval']['high']:{spec}}]"
        if "count" in self:
            text += f" ({self['count']}/{self['total']})"
        return text


def shown(value, spec):
    return "-" if value is None else format(value, spec)


def geometric_mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values))


def at_most(count, total):
    """One-sided 95 % limit of a share in per cent (Clopper and Pearson 1934)."""
    if count >= total:
        return 100.0
    low, high = 0.0, 1.0
    for _ in range(60):
        p = (low + high) / 2
        tail = sum(math.comb(total, k) * p**k * (1 - p)**(total - k)
                   for k in range(count + 1))
        low, high = (p, high) if tail > 0.05 else (low, p)
    return 100.0 * high


def with_sum(rows, keys, **rest):
    """The rows and a last one: sums of `keys`, and `rest` in its other columns."""
    rows = list(rows)
    return rows + [{**rest, **{key: sum(row[key] for row in rows) for key in keys}}]


def programs_run(kept, names):
    """What tests/parts/run_parts.py left of each test program named."""
    none = {"tests": 0, "passed": 0, "skipped": 0, "failed": [],
            "processor_s": 0.0, "commit": "not run"}
    rows = []
    for name in names.split():
        one = kept.get(name, none)
        rows.append({**one, "program": name.removeprefix("test_"),
                     "failed": len(one["failed"])})
    return rows


# What expressions may call.
HELPERS = {"shown": shown, "geometric_mean": geometric_mean, "at_most": at_most,
           "with_sum": with_sum, "programs_run": programs_run}


def load():
    """All steps, the blocks of each page, and tables."""
    steps, blocks, tables = {}, {}, {}
    for path in sorted((ROOT / "workflow/evidence").glob("*.toml")):
        table = tomllib.loads(path.read_text())
        for name, step in table.get("step", {}).items():
            if name in steps:
                raise Failure(f"{path.name}: step '{name}' is there twice")
            steps[name] = step
        for name, text in table.get("block", {}).items():
            if name in blocks:
                raise Failure(f"{path.name}: block '{name}' is there twice")
            blocks[name] = (table["page"], text)
        for name, one in table.get("table", {}).items():
            if name in tables:
                raise Failure(f"{path.name}: table '{name}' is there twice")
            tables[name] = one
    return steps, blocks, tables


def git(*arguments):
    return subprocess.run(["git", "-C", ROOT, *arguments], check=True,
                          capture_output=True, text=True).stdout.strip()


def commit():
    changed = git("status", "--porcelain", "--untracked-files=no", "--", *SOURCES)
    return git("log", "-1", "--format=%h", "--abbrev=7", "--", *SOURCES) + (
        " and changes" if changed else "")


def first(path, pattern, otherwise):
    try:
        found = re.search(pattern, pathlib.Path(path).read_text(), re.M)
    except OSError:
        found = None
    return found.group(1) if found else otherwise


def machine():
    return "%s, %d threads, %s" % (
        first("/proc/cpuinfo", r"^model name\s*: (.*)$", platform.machine()),
        os.cpu_count(),
        first("/etc/os-release", r'^PRETTY_NAME="?([^"\n]*)', platform.system()))


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def prepare(folder, build, data):
    """Names of the project's root, so that commands read as in the pages."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, target in [("configs", ROOT / "configs"), ("workflow", ROOT / "workflow"),
                         ("examples", ROOT / "examples"), ("tests", ROOT / "tests"),
                         ("build", build), ("data", data)]:
        link = folder / name
        link.unlink(missing_ok=True)
        link.symlink_to(target)
    driver = folder / "kinegraph"
    driver.write_text(f'#!/bin/bash\nname=$1\nshift\n'
                      f'exec "{build}/apps/kinegraph-$name" "$@"\n')
    driver.chmod(0o755)


def read(folder, file):
    """What a file says; of all that match a pattern: by name without ending."""
    if file.endswith(".jsonl"):
        return [json.loads(line)
                for line in (folder / file).read_text().splitlines()]
    if not file.endswith(".json"):
        return (folder / file).read_text()
    if "*" not in file:
        return json.loads((folder / file).read_text())
    return {path.stem: json.loads(path.read_text()) for path in folder.glob(file)}


def run(name, step, build, data):
    """Runs the commands; what they were run on stays beside their results."""
    folder = build / "evidence" / name
    if folder.exists():  # of a run before
        shutil.rmtree(folder)
    prepare(folder, build, data)
    if "targets" in step:
        subprocess.run(["cmake", "--build", build, "--target", *step["targets"]],
                       check=True, stdout=subprocess.DEVNULL)
    made_from = commit()
    begin = time.monotonic()
    with open(folder / "log.txt", "w") as log:
        for line in step["run"]:
            if subprocess.run(["bash", "-euo", "pipefail", "-c", line], cwd=folder,
                              stdin=subprocess.DEVNULL, stdout=log,
                              stderr=log).returncode:
                raise Failure(f"{name}: '{line}' failed; its words are in "
                              f"{folder}/log.txt")
    made = {"commit": made_from, "machine": machine(),
            "seconds": round(time.monotonic() - begin, 1), "run": step["run"]}
    (folder / "made.json").write_text(json.dumps(made))


def keep(name, step, build):
    """The figures of the last run, to docs/evidence."""
    folder = build / "evidence" / name
    if not (folder / "made.json").exists():
        raise Failure(f"{name}: nothing was run in {folder}")
    made = json.loads((folder / "made.json").read_text())
    names = {**HELPERS, **{
        key: read(folder, file) for key, file in step.get("read", {}).items()}}
    kept = {**made, "figures": {key: eval(text, dict(names)) for key, text
                                in step.get("figures", {}).items()}}
    files = {}
    for source, place in step.get("files", {}).items():
        (ROOT / place).write_bytes((folder / source).read_bytes())
        files[place] = digest(ROOT / place)
    if files:
        kept["files"] = files
    KEPT.mkdir(exist_ok=True)
    (KEPT / f"{name}.json").write_text(
        json.dumps(kept, indent=1, ensure_ascii=False) + "\n")


def markdown(table, scope):
    """A table of Markdown from a list of rows."""
    scope = {**HELPERS, **scope}
    heads = [head for head, _ in table["columns"]]
    lines = [heads, ["---"] * len(heads)]
    for row in eval(table["rows"], scope):
        lines.append([text.format(**row) for _, text in table["columns"]])
    return "\n".join("| " + " | ".join(cells) + " |" if cells[0] != "---"
                     else "|" + "|".join(cells) + "|" for cells in lines)


def rendered(steps, blocks, tables):
    """The text of every block, and what is wrong with the evidence."""
    wrong, scope = [], {}
    for name, step in steps.items():
        path = KEPT / f"{name}.json"
        if not path.exists():
            wrong.append(f"step '{name}' has not been run")
            continue
        kept = json.loads(path.read_text(), object_hook=Figure)
        if kept["run"] != step["run"]:
            wrong.append(f"step '{name}': its commands have changed since it ran")
        if set(kept["figures"]) != set(step.get("figures", {})):
            wrong.append(f"step '{name}': its figures have changed since it ran")
        for place, value in kept.get("files", {}).items():
            if not (ROOT / place).exists() or digest(ROOT / place) != value:
                wrong.append(f"{place} is not what step '{name}' made")
        scope[name] = {**kept["figures"], **{
            key: kept[key] for key in ("commit", "machine", "seconds")
            if key in kept}}
    for path in KEPT.glob("*.json"):
        if path.stem not in steps:
            wrong.append(f"docs/evidence/{path.name} belongs to no step")
    texts, made = {}, {}
    for name, table in tables.items():
        try:
            made[name] = markdown(table, scope)
        except Exception as error:  # whatever the expression can raise
            wrong.append(f"table '{name}': {type(error).__name__} {error}")
    scope["table"] = made
    for name, (page, text) in blocks.items():
        try:
            texts[name] = (page, text.strip("\n").format(**scope))
        except (KeyError, IndexError, TypeError, ValueError) as error:
            wrong.append(f"block '{name}': {type(error).__name__} {error}")
    return texts, wrong


MARKED = re.compile(r"(<!-- evidence:(\w+) -->\n)(.*?)(<!-- /evidence -->)", re.S)


def index(steps, texts):
    """docs/evidence/README.md: which command, commit and machine."""
    lines = ["# Evidence", "",
             "What the marked figures of the pages come from, made by `./kinegraph "
             "evidence`; `./kinegraph evidence --check` compares. The commands "
             "stand in each file. *Taken over*: figures that a page had, of that "
             "commit; a later `--only=FILE` replaces them.", "",
             "| file | commit | machine | seconds |", "|---|---|---|---|"]
    for name in sorted(steps):
        path = KEPT / f"{name}.json"
        if path.exists():
            kept = json.loads(path.read_text())
            lines.append(f"| [{name}]({name}.json) | {kept['commit']} | "
                         f"{kept['machine']} | {kept['seconds']:.0f} |"
                         if "seconds" in kept else
                         f"| [{name}]({name}.json) | {kept['commit']} | "
                         f"{kept['machine']} | taken over |")
    pages = sorted({page for page, _ in texts.values()})
    lines += ["", "Pages with marked figures: " + ", ".join(
        f"[{page}]({os.path.relpath(page, 'docs/evidence')})" for page in pages) + "."]
    return "\n".join(lines) + "\n"


def pages(steps, texts):
    """What every page should be."""
    wanted, wrong, placed = {}, [], set()
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        page = str(path.relative_to(ROOT))
        text = path.read_text()

        def fill(match):
            name = match.group(2)
            placed.add(name)
            if name not in texts or texts[name][0] != page:
                wrong.append(f"{page}: no block '{name}' is known for it")
                return match.group(0)
            return match.group(1) + texts[name][1] + "\n" + match.group(4)

        wanted[path] = MARKED.sub(fill, text)
        if len(MARKED.findall(text)) != text.count("<!-- evidence:"):
            wrong.append(f"{page}: a marker 'evidence' has no end")
    wrong += [f"block '{name}' stands on no page" for name in texts
              if name not in placed]
    wanted[KEPT / "README.md"] = index(steps, texts)
    return wanted, wrong


def check(wanted):
    wrong = []
    for path, text in wanted.items():
        there = path.read_text() if path.exists() else ""
        if there == text:
            continue
        pairs = zip(there.splitlines() + [""] * 9999, text.splitlines())
        here, due = next((a, b) for a, b in pairs if a != b) if text else ("", "")
        wrong.append(f"{path.relative_to(ROOT)} says\n  {here}\nevidence says\n  {due}")
    return wrong


def main():
    parser = argparse.ArgumentParser(
        prog="kinegraph evidence",
        description="Remakes the figures of the documentation from programs' JSON.")
    parser.add_argument("--only", default="", metavar="STEP,...",
                        help="steps to run; default: all that are not slow")
    parser.add_argument("--render", action="store_true",
                        help="run nothing, fill the pages from docs/evidence")
    parser.add_argument("--reread", action="store_true",
                        help="run nothing, take the figures of --only from what "
                             "its last run left in the build folder")
    parser.add_argument("--check", action="store_true",
                        help="run and write nothing; pages must be up to date")
    parser.add_argument("--list", action="store_true", help="names of the steps")
    parser.add_argument("--build", default=ROOT / "build", type=pathlib.Path,
                        help="folder of the build")
    flags = parser.parse_args()
    steps, blocks, tables = load()
    if flags.list:
        print("\n".join(steps))
        return 0
    chosen = [name for name in flags.only.split(",") if name] or [
        name for name, step in steps.items() if not step.get("slow")]
    for name in chosen:
        if name not in steps:
            raise Failure(f"no step is named '{name}', there are {', '.join(steps)}")
    if flags.reread:
        for name in chosen:
            keep(name, steps[name], flags.build.resolve())
    elif not flags.check and not flags.render:
        data = pathlib.Path(os.environ.get("KINEGRAPH_DATA", ROOT / "../shared/data"))
        if not data.is_dir():
            raise Failure(f"needs the data folder (KINEGRAPH_DATA), no '{data}'")
        for name in chosen:
            print(f"kinegraph: evidence: {name}", file=sys.stderr)
            run(name, steps[name], flags.build.resolve(), data.resolve())
            keep(name, steps[name], flags.build.resolve())
    texts, wrong = rendered(steps, blocks, tables)
    wanted, more = pages(steps, texts)
    if flags.check:
        more += check(wanted)
    elif not wrong and not more:
        for path, text in wanted.items():
            path.write_text(text)
    for line in wrong + more:
        print(f"kinegraph: error: {line}", file=sys.stderr)
    return 1 if wrong or more else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failure as failure:
        print(f"kinegraph: error: {failure}", file=sys.stderr)
        sys.exit(2)
