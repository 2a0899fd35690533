#!/usr/bin/env python3
"""Runs public NC programs with `counterpoint run` and compares the outcome with the verdicts of programs.tsv.

usage: run.py [--counterpoint BINARY] [--mirror DIR] [--cache DIR] [--out FILE] [--seconds N] [--tables] [FILTER ...]

programs.tsv points at programs in public repositories, repositories.tsv says which commit and under which licence. No
program is kept here: a repository is fetched once into the cache folder, or read from DIR/owner+name of `--mirror`.
A machine is a shipped one or a folder of `machines`; `tools` has the tool tables of repositories whose programs need one.
FILTER is a part of family, machine, repository, file or verdict. The exit code is 1 if an outcome differs from its verdict.
"""
import argparse
import collections
import json
import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))

# What a control would do with a program, and what a run of it did.
VERDICTS = ("clean", "alarm", "false", "silent")

Program = collections.namedtuple("Program", "family machine repository files verdict expected reason line")
Repository = collections.namedtuple("Repository", "commit licence")


def rows(path, columns):
    """Rows of a table: (number of the line, fields). The first line names the columns; empty lines and lines with # are skipped."""
    with open(path, encoding="utf-8") as file:
        lines = [(number, line.rstrip("\n")) for number, line in enumerate(file, 1)]
    lines = [(number, line.split("\t")) for number, line in lines if line and not line.startswith("#")]
    if lines[0][1] != columns:
        sys.exit(f"{path}:1: the columns are {lines[0][1]}, not {columns}")
    for number, fields in lines[1:]:
        if len(fields) != len(columns):
            sys.exit(f"{path}:{number}: {len(fields)} fields, not {len(columns)}")
    return lines[1:]


def read_programs(path):
    """The list of programs. `expected` is the set of numbers of the errors of a run."""
    programs = []
    for number, fields in rows(path, ["family", "machine", "repository", "files", "verdict", "expected", "reason"]):
        family, machine, repository, files, verdict, expected, reason = fields
        if verdict not in VERDICTS:
            sys.exit(f"{path}:{number}: the verdict is '{verdict}', not one of {', '.join(VERDICTS)}")
        expected = frozenset(expected.split()) if expected != "-" else frozenset()
        programs.append(Program(family, machine, repository, files.split(" + "), verdict, expected, reason, number))
    return programs


def read_repositories(path):
    """Commit and licence of each repository."""
    found = rows(path, ["repository", "commit", "licence"])
    return {name: Repository(commit, licence) for _, (name, commit, licence) in found}


def split_range(file):
    """`path@7-40` is lines 7 to 40 of the file, `path@7-` from line 7 on: (path, first, last)."""
    found = re.fullmatch(r"(.*)@(\d+)-(\d*)", file)
    if not found:
        return file, 1, None
    return found.group(1), int(found.group(2)), int(found.group(3)) if found.group(3) else None


def cut(data, first, last):
    """Lines first to last of a file, with their ends."""
    return b"".join(data.splitlines(keepends=True)[first - 1 : last])


def git(folder, *arguments):
    """Output of git in a repository without work tree."""
    command = ["git", "--git-dir", folder, *arguments]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE).stdout


def git_folder(name, commit, mirror, cache):
    """The git directory of a repository: of the mirror, of the cache, or fetched into the cache."""
    if mirror:
        folder = os.path.join(mirror, name.replace("/", "+"))
        inner = [os.path.join(folder, *names) for names in (("repo", ".git"), ("repo",))]
        return next((path for path in inner if os.path.isdir(path)), folder)
    folder = os.path.join(cache, name.replace("/", "+") + ".git")
    if not os.path.isdir(folder):
        url = f"https://github.com/{name}.git"
        subprocess.run(["git", "clone", "--quiet", "--bare", "--filter=blob:none", url, folder], check=True)
    try:
        git(folder, "cat-file", "-e", commit)
    except subprocess.CalledProcessError:
        git(folder, "fetch", "--quiet", "origin", commit)
    return folder


def lay_out(program, folder, read):
    """Writes the files of a program into a folder: the main program there, the others below `with`. Returns main program and others."""
    paths = []
    for k, file in enumerate(program.files):
        path, first, last = split_range(file)
        below = os.path.join(folder, "with") if k else folder
        os.makedirs(below, exist_ok=True)
        target = os.path.join(below, os.path.basename(path))
        with open(target, "wb") as out:
            out.write(cut(read(path), first, last))
        paths.append(target)
    return paths[0], paths[1:]


def run(binary, program, read, seconds):
    """Runs a program: the summary, or a text that says why there is none."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            main, others = lay_out(program, folder, read)
        except subprocess.CalledProcessError as error:
            return f"not fetched: {error.stderr.decode(errors='replace').strip()}"
        own = os.path.join(HERE, "machines", program.machine)
        machine = own if os.path.isdir(own) else program.machine
        command = [binary, "run", "--json", "--no-timeline", "--machine", machine, "--max-blocks", "2000000"]
        command += ["--max-time", "1000000", main]
        tools = os.path.join(HERE, "tools", program.repository.replace("/", "+") + ".csv")
        if os.path.exists(tools):
            command += ["--tools", tools]
        if others:
            command += ["--with", os.path.join(folder, "with")]
        try:
            done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds, check=False)
        except subprocess.TimeoutExpired:
            return f"no end in {seconds} s"
        try:
            return json.loads(done.stdout)
        except json.JSONDecodeError:
            return done.stderr.decode(errors="replace").strip().splitlines()[-1:] or ["no output"]


def base(machine):
    """The shipped machine that a machine is, or that its folder extends."""
    path = os.path.join(HERE, "machines", machine, "machine.toml")
    if not os.path.exists(path):
        return machine
    with open(path, encoding="utf-8") as file:
        return re.search(r'^extends = "(.*)"', file.read(), re.M).group(1)


def guess(binary, program, read, seconds):
    """The machine that is guessed for a program, or `-`, and the reason."""
    with tempfile.TemporaryDirectory() as folder:
        main, _ = lay_out(program, folder, read)
        command = [binary, "run", "--no-timeline", "--max-blocks", "1", main]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=seconds, check=False)
        told = done.stderr.decode(errors="replace").strip()
        found = re.search(r"^machine (\S+), guessed from (.*); use --machine", told, re.M)
        return found.groups() if found else ("-", told.splitlines()[-1] if told else "no output")


def guesses(binary, programs, read_of, seconds):
    """Compares the guesses with guesses.tsv; returns how many differ."""
    listed = {}
    for _, (repository, file, machine, _) in rows(os.path.join(HERE, "guesses.tsv"), ["repository", "file", "guess", "reason"]):
        listed[(repository, file)] = machine
    wrong = 0
    for program in programs:
        found, why = guess(binary, program, read_of(program), seconds)
        expected = listed.get((program.repository, program.files[0]), base(program.machine))
        if found != expected:
            wrong += 1
            print(f"programs.tsv:{program.line}: {program.repository} {program.files[0]}\n    {found} instead of {expected}: {why}")
    print(f"{wrong} of {len(programs)} guesses differ from the list")
    return wrong


def outcome(summary):
    """What a run did: succeeded, stopped (by errors or a verdict) or not run, the numbers of its errors, and its first error."""
    if not isinstance(summary, dict):
        return "not run", frozenset(), summary if isinstance(summary, str) else summary[0]
    errors = [found for found in summary["diagnostics"] if found["severity"] >= 8]
    numbers = frozenset(str(found["number"]) for found in errors)
    first = ""
    if errors:
        where = f"{os.path.basename(errors[0].get('file') or '')}:{errors[0].get('line')}"
        first = f"{where}: {errors[0]['text']} [{(errors[0].get('block') or '').strip()}]"
    if summary["verdict"]:
        kind = summary["verdict"]["kind"]
        return "stopped", numbers | {kind}, first or summary["verdict"]["text"]
    return ("stopped" if errors else "succeeded"), numbers, first


def differs(program, state, numbers):
    """Whether a run did something else than the list says. A program that runs clean has no errors; one that alarms has those of the list."""
    return state == "not run" or numbers != program.expected


def table(programs, results):
    """Programs by family and verdict, as rows of text."""
    count = collections.OrderedDict()
    for program, (state, _, _) in zip(programs, results):
        line = count.setdefault(program.family, collections.Counter())
        line.update(["programs", program.verdict, state])
    head = ["family", "programs", *VERDICTS, "succeeded", "stopped", "not run"]
    total = sum(count.values(), collections.Counter())
    lines = [head]
    for family, line in [*count.items(), ("all", total)]:
        lines.append([family, *(str(line[name]) for name in head[1:])])
    widths = [max(len(line[k]) for line in lines) for k in range(len(head))]
    return ["  ".join(field.ljust(width) for field, width in zip(line, widths)).rstrip() for line in lines]


def kind(program):
    """The row of the table of verdicts that a program counts in: the control, and mill or lathe where both are listed."""
    both = program.family in ("fanuc", "haas", "siemens")
    return program.family + (" lathe" if "lathe" in program.machine else " mill") * both


def markdown(programs):
    """The two tables of docs/coverage/programs.md: verdicts by control, and what is false or silent by reason."""
    count, reasons = collections.OrderedDict(), collections.OrderedDict()
    for program in programs:
        count.setdefault(kind(program), collections.Counter()).update(["programs", program.verdict])
        if program.verdict in ("false", "silent"):
            reasons.setdefault((program.verdict, program.reason), []).append(program)
    count["all"] = sum(count.values(), collections.Counter())
    lines = ["| control | programs | clean | real alarm | false alarm | silent |", "|---|---|---|---|---|---|"]
    for name, line in count.items():
        lines.append(f"| {name} | " + " | ".join(str(line[column]) for column in ["programs", *VERDICTS]) + " |")
    lines += ["", "| programs | what the control does | first one |", "|---|---|---|"]
    for (verdict, reason), found in sorted(reasons.items(), key=lambda row: (row[0][0] != "silent", -len(row[1]))):
        first = f"`{found[0].machine}`, {found[0].repository}: {os.path.basename(found[0].files[0])}"
        lines.append(f"| {len(found)}{' silent' * (verdict == 'silent')} | {reason} | {first} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--mirror", help="folder of bare git directories named owner+name, instead of GitHub")
    parser.add_argument("--cache", default=os.path.expanduser("~/.cache/counterpoint-public"))
    parser.add_argument("--out", help="file for the outcomes as JSON")
    parser.add_argument("--seconds", type=float, default=60, help="longest run of a program")
    parser.add_argument("--list", default=os.path.join(HERE, "programs.tsv"))
    parser.add_argument("--tables", action="store_true", help="print the tables of docs/coverage/programs.md and run nothing")
    parser.add_argument("--guess", action="store_true", help="run without a machine and compare the guesses with guesses.tsv")
    parser.add_argument("filters", nargs="*", metavar="FILTER")
    args = parser.parse_args()
    repositories = read_repositories(os.path.join(os.path.dirname(args.list), "repositories.tsv"))
    programs = read_programs(args.list)
    for word in args.filters:
        programs = [p for p in programs if word in "\t".join([p.family, p.machine, p.repository, p.verdict, *p.files])]
    if args.tables:
        print("\n".join(markdown(programs)))
        return
    os.makedirs(args.cache, exist_ok=True)
    if args.guess:
        def read_of(program):
            commit = repositories[program.repository].commit
            folder = git_folder(program.repository, commit, args.mirror, args.cache)
            return lambda path: git(folder, "show", f"{commit}:{path}")
        sys.exit(1 if guesses(args.counterpoint, programs, read_of, args.seconds) else 0)
    results, report, wrong = [], [], 0
    for program in programs:
        commit = repositories[program.repository].commit
        folder = git_folder(program.repository, commit, args.mirror, args.cache)
        summary = run(args.counterpoint, program, lambda path: git(folder, "show", f"{commit}:{path}"), args.seconds)
        state, numbers, first = outcome(summary)
        results.append((state, numbers, first))
        different = differs(program, state, numbers)
        wrong += different
        report.append({**program._asdict(), "expected": sorted(program.expected), "state": state})
        report[-1].update(errors=sorted(numbers), first=first, differs=different)
        if different:
            found = " ".join(sorted(numbers)) or "-"
            print(f"programs.tsv:{program.line}: {program.machine} {program.repository} {program.files[0]}")
            print(f"    {state}, {found} instead of {' '.join(sorted(program.expected)) or '-'}: {first}")
    if args.out:
        with open(args.out, "w", encoding="utf-8") as file:
            json.dump(report, file, indent=1)
    print("\n".join(table(programs, results)))
    codes = collections.Counter(number for _, numbers, _ in results for number in numbers)
    print("errors by number: " + (", ".join(f"{number} in {n}" for number, n in codes.most_common()) or "none"))
    print(f"{wrong} of {len(programs)} programs differ from the list")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
