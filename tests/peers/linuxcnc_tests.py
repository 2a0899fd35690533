#!/usr/bin/env python3
"""Runs the programs of LinuxCNC's own interpreter tests by `counterpoint run` on the machine `linuxcnc-mill` and compares
the moves with those that the tests expect. Nothing of them is kept here.

usage: linuxcnc_tests.py REPOSITORY [--counterpoint BINARY] [--show NAME]

REPOSITORY is a (bare) clone of github.com/LinuxCNC/linuxcnc. A test counts if it consists of `rs274 -g` on one program
without a configuration of its own; the expected text is read from the file `expected` of its folder.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile

import rs274
from linuxcnc import MACHINE, moves_of
from rs274 import ROOT

ROUNDED = 2e-4


def git(repository, *words):
    return subprocess.run(["git", "-C", repository, *words], capture_output=True, check=True).stdout


def tests(repository):
    """Folder, program and expected text of each test."""
    names = git(repository, "ls-tree", "-r", "--name-only", "HEAD", "tests/interp").decode().splitlines()
    for name in names:
        if not name.endswith("/expected"):
            continue
        folder = name[:-len("/expected")]
        script = f"{folder}/test.sh"
        if script not in names:
            continue
        words = git(repository, "show", f"HEAD:{script}").decode(errors="replace")
        found = re.search(r"rs274 (.*?)([\w.-]+\.ngc)\b", words)
        if not found or any(option in found.group(1) for option in ("-i", "-v", "$")) or "-g" not in found.group(1):
            continue
        program = f"{folder}/{found.group(2)}"
        if program in names:
            yield folder, git(repository, "show", f"HEAD:{program}").decode(errors="replace"), \
                git(repository, "show", f"HEAD:{name}").decode(errors="replace")


def near(own, peer):
    for at, (a, b) in enumerate(zip(own, peer)):
        if a[0] != b[0] or max(abs(x - y) for x, y in zip(a[1], b[1])) > ROUNDED:
            return f"move {at + 1}: {a} here, {b} expected"
    return "" if len(own) == len(peer) else f"{len(own)} moves here, {len(peer)} expected"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repository")
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--show")
    args = parser.parse_args()
    counts = {"equal": 0, "different": 0}
    with tempfile.TemporaryDirectory() as folder:
        os.mkdir(os.path.join(folder, "peer"))
        with open(os.path.join(folder, "peer", "machine.toml"), "w", encoding="ascii") as file:
            file.write(MACHINE)
        for name, program, expected in tests(args.repository):
            if args.show and args.show not in name:
                continue
            lines = program.splitlines()
            own, told = rs274.own_moves(args, folder, "test", lines, "")
            peer = moves_of(expected, [0.0] * 3)
            if not peer:
                continue
            what = near(own, peer)
            counts["different" if what else "equal"] += 1
            print(f"{name[len('tests/interp/'):]}: {what or f'{len(peer)} moves'}" + (f" ({told[:200]})" if what else ""))
            if args.show:
                for number, line in enumerate(lines, 1):
                    print(f"{number:4} {line}")
                for a in own:
                    print("own", a)
                for b in peer:
                    print("expected", b)
    print(", ".join(f"{count} {kind}" for kind, count in counts.items()))
    return 1 if counts["different"] else 0


if __name__ == "__main__":
    sys.exit(main())
