#!/usr/bin/env python3
"""Runs the programs of LinuxCNC's own interpreter tests by `counterpoint run` on the machine `linuxcnc-mill` and compares
the moves with those that the tests expect. Nothing of them is kept here.

usage: linuxcnc_tests.py REPOSITORY [--counterpoint BINARY] [--show NAME]

REPOSITORY is a (bare) clone of github.com/LinuxCNC/linuxcnc. A test counts if it consists of `rs274 -g` on one program
without a configuration of its own; the expected text is read from the file `expected` of its folder. Its table of
tools is added to the machine. Two moves at feed in one direction count as one, a rigid tap as a move and its return.
KNOWN lists the tests that differ for a reason.
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

# Tests that differ, and why.
LATHE = "the roughing cycles G70 to G72 of LinuxCNC are not in this control"
TAP = "a mistake of the interpreter: in G18 and G19 it taps along another axis"
LEAD_IN = "the lead-in of cutter compensation ends square to the next move, in LinuxCNC square to itself"
KNOWN = {
    "crazy-paths": LEAD_IN,
    "inside-corners": LEAD_IN,
    "inverse-time-with-comp": LEAD_IN,
    "g71-endless-loop": LATHE,
    "g71-endless-loop2": LATHE,
    "g71-endless-loop_2": LATHE,
    "g71-with-g70": LATHE,
    "g72-facing": LATHE,
    "g72-missing-iteration": LATHE,
    "g84/g18/g98": TAP,
    "g84/g18/g99": TAP,
    "g84/g19/g98": TAP,
    "g84/g19/g99": TAP,
    "m98m99/12-M99-endless-main-program": "M99 of the main program repeats it, as on the machine; rs274 alone ends",
}


def git(repository, *words):
    return subprocess.run(["git", "-C", repository, *words], capture_output=True, check=True).stdout


def tests(repository):
    """Folder, program, table of tools and expected text of each test."""
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
        table = re.search(r"-t +([\w.-]+)", words)
        table = f"{folder}/{table.group(1)}" if table else ""
        if not found or any(option in found.group(1) for option in ("-i", "-v", "$")) or "-g" not in found.group(1):
            continue
        program = f"{folder}/{found.group(2)}"
        if program in names:
            text = lambda path: git(repository, "show", f"HEAD:{path}").decode(errors="replace")
            yield folder, text(program), text(table) if table in names else "", text(name)


def tool_rows(table):
    """Rows of the machine for a table of tools, whose unit is the inch of rs274."""
    rows = []
    for line in table.splitlines():
        words = dict(re.findall(r"\b([TPXYZD])\s*([+-]?[\d.]+)", line.split(";")[0]))
        if "T" not in words:
            continue
        values = ", ".join(f"{axis} = {float(words[axis]) * 25.4!r}" for axis in "XYZ" if axis in words)
        radius = f"radius = {abs(float(words.get('D', 0))) * 12.7!r}\n"
        rows.append(f"[[tool.offsets]]\nnumber = {int(float(words['T']))}\nvalues = {{ {values} }}\n{radius}")
    return "\n".join(rows)


def rigid_taps(expected):
    """The expected text with a rigid tap as a move and its way back."""
    lines, last = [], None
    for line in expected.splitlines():
        found = re.search(r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|RIGID_TAP)\((.*)\)$", line)
        if found and found.group(1) == "RIGID_TAP" and last:
            lines += [f"STRAIGHT_FEED({found.group(2)}, 0, 0, 0)", f"STRAIGHT_FEED({last})"]
            continue
        last = found.group(2) if found else last
        lines.append(line)
    return "\n".join(lines)


def joined(moves, unit):
    """The moves without those that rounding makes; two at feed in one direction are one."""
    out, at = [], [0.0] * 3
    for kind, to in moves:
        if kind in ("rapid", "feed") and max(abs(a - b) for a, b in zip(at, to)) <= ROUNDED * unit:
            continue
        at = to[:3]
        if len(out) > 1 and kind == "feed" == out[-1][0] and len(out[-2][1]) >= 3:
            first, second = ([b - a for a, b in zip(*ends)] for ends in ((out[-2][1], out[-1][1]), (out[-1][1], to)))
            product = sum(a * b for a, b in zip(first, second))
            size = (sum(a * a for a in first) * sum(b * b for b in second)) ** 0.5
            if size and product / size > 1 - 1e-9 and sum(map(bool, [abs(v) > ROUNDED for v in second])) == 1:
                out[-1] = (kind, to)
                continue
        out.append((kind, to))
    return out


def near(own, peer, unit):
    for at, (a, b) in enumerate(zip(own, peer)):
        if a[0] != b[0] or max(abs(x - y) for x, y in zip(a[1], b[1])) > ROUNDED * unit:
            return f"move {at + 1}: {a} here, {b} expected"
    return "" if len(own) == len(peer) else f"{len(own)} moves here, {len(peer)} expected"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repository")
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--show")
    args = parser.parse_args()
    counts = {"equal": 0, "different": 0, "different for a reason": 0}
    with tempfile.TemporaryDirectory() as folder:
        os.mkdir(os.path.join(folder, "peer"))
        for name, program, table, expected in tests(args.repository):
            if args.show and args.show not in name:
                continue
            with open(os.path.join(folder, "peer", "machine.toml"), "w", encoding="ascii") as file:
                file.write(MACHINE + "\n" + tool_rows(table))
            lines = program.splitlines()
            own, told = rs274.own_moves(args, folder, "test", lines, "")
            unit = 25.4 if "CANON_UNITS_INCHES" in expected else 1
            own, peer = joined(own, unit), joined(moves_of(rigid_taps(expected), [0.0] * 3), unit)
            if not peer:
                continue
            what, short = near(own, peer, unit), name[len("tests/interp/"):]
            reason = KNOWN.get(short, "") if what else ""
            counts["different for a reason" if reason else "different" if what else "equal"] += 1
            print(f"{short}: {reason or what or f'{len(peer)} moves'}" + (f" ({told[:200]})" if what and not reason else ""))
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
