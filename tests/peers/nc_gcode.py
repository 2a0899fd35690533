#!/usr/bin/env python3
"""Runs the examples of nc-gcode-interpreter (MIT, CEAD-group/nc-gcode-interpreter) by `counterpoint run` and compares the
positions that the axes come to with the tables that lie beside the examples, to 0.001 mm.

usage: nc_gcode.py EXAMPLES [--counterpoint BINARY] [--only NAME]

EXAMPLES is the folder `examples` of a checkout. Each example runs on a milling machine with the axes that its table has, with the
variables of `defaults.mpf` as global ones and a feed of 1000 mm/min before its first move, since that interpreter asks
for none. Compared is the way through the axes of the table: one row for every position that differs from the one before. Tables
hold what is programmed plus TRANS, so circles and splines are compared by their ends.

What the control would refuse in an example is written as the control wants it first (ADAPTED, with the reason). Examples that
cannot be run here are listed in REFUSED. One that is not listed and differs, or that is listed and does not, is an error.
"""
import argparse
import csv
import json
import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
NEAR = 1e-3
WORDS = {"N", "F", "S", "M", "T", "D", "I", "J", "K", "CR", "PW", "SD", "PL", "comment", "non_returning_function_call"}

# What is written otherwise, by example, and why.
ADAPTED = {
    "arrays": [("FOR nn=", "DEF INT nn, m, o\nFOR nn=", "variables are defined before they are used (alarm 12550)")],
    "for_loop": [("NUMBER", "NUMBER_OF", "NUMBER is the name of a function (alarm 12170)")],
    "repeat": [("NUMBER", "NUMBER_OF", "NUMBER is the name of a function (alarm 12170)")],
    "r_param": [("DEF REAL R0=0", "R0=0", "R parameters are not defined (alarm 12170)")],
    "function_calls": [("12345", "63000", "SETAL sets alarms 60000 to 69999, and from 61000 on many stop the program")],
    "logic_operators": [("(TRACK_X == 1 AND TRACK_Y == 1)", "((TRACK_X == 1) AND (TRACK_Y == 1))",
                         "comparisons bind weakest on the control")],
    "multiple_m_codes": [(f"M10{k}", "M8", "what M101 to M103 do is up to the builder of a machine") for k in (1, 2, 3)],
}

# What is not run, by example, and why.
REFUSED = {
    "axis_index_assignment": "ACC of an axis E, which the machine does not have",
    "defaults": "axis E",
    "edge_cases": "axis ELX",
    "simple": "a circle without centre and radius (alarm 14040)",
    "spline": "BSPLINE and ASPLINE (alarm 12550)",
}

# Positions of the axes before a program, as defaults.mpf leaves them.
HOME = {"X": 1600, "Y": 900, "Z": 0}


def is_axis(column):
    return column not in WORDS and not column.startswith("gg")


def expected(path):
    """The axes of a table and the positions in it; None where an axis has none yet."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    axes = [column for column in (rows[0] if rows else []) if is_axis(column)]
    way = []
    for row in rows:
        at = [float(row[axis]) if row[axis] else None for axis in axes]
        if any(value is not None for value in at) and (not way or way[-1] != at):
            way.append(at)
    return axes, way


def machine(folder, axes):
    """The machine of an example: with a swivelling table where it moves A or C."""
    base = "siemens-mill-5axis" if {"A", "C"} & set(axes) else "siemens-mill"
    text = f'extends = "{base}"\n[ce]\nname = "peer"\n'
    for axis, home in HOME.items():
        text += f'[[axes]]\nname = "{axis}1"\nrapid = 10_000\nhome = {home}\n'
    if "A" in axes:
        text += '[[axes]]\nname = "A1"\nrapid = 10_000\nhome = 0\nlimits = [-360, 360]\n'
    os.makedirs(os.path.join(folder, "peer"), exist_ok=True)
    with open(os.path.join(folder, "peer", "machine.toml"), "w", encoding="ascii") as file:
        file.write(text)


def globals_of(text):
    """The variables of defaults.mpf that an example does not define itself, as a file of definitions."""
    values = {"AA": 15, "BB": 9, "START_CC": 10, "START_CC_SPEED": 0.5, "EXTRUSION_MULTIPLIER": 1, "RETRACT_CC": 1}
    own = " ".join(line for line in text.upper().splitlines() if line.startswith("DEF "))
    lines = []
    for name, value in values.items():
        if not re.search(rf"\b{name}\b", own):
            lines.append(f"DEF NCK {'INT' if name in ('AA', 'BB') else 'REAL'} {name}={value}")
    return "\n".join([*lines, "M17"]) + "\n"


def with_feed(text):
    """The example with a feed before the first line that is neither empty, nor a comment, nor a definition."""
    lines = text.splitlines()
    for at, line in enumerate(lines):
        if not re.match(r"\s*(;|DEF\b|$)", line, re.IGNORECASE):
            return "\n".join([*lines[:at], "F1000", *lines[at:]]) + "\n"
    return text


def run(args, folder, name, axes):
    """Positions of the axes, one for every move that changes them, and what the control says."""
    with open(os.path.join(args.examples, name + ".mpf"), encoding="utf-8") as file:
        text = file.read()
    for written, wanted, _ in ADAPTED.get(name, []):
        text = text.replace(written, wanted)
    program, definitions = os.path.join(folder, name + ".mpf"), os.path.join(folder, "ugud.def")
    with open(program, "w", encoding="utf-8") as file:
        file.write(with_feed(text))
    with open(definitions, "w", encoding="ascii") as file:
        file.write(globals_of(text))
    machine(folder, axes)
    out = os.path.join(folder, name)
    done = subprocess.run([args.counterpoint, "run", "--quiet", "--machine", os.path.join(folder, "peer"), "--with", definitions,
                           "--out", out, "--write", "events", program], capture_output=True, text=True, check=False)
    way, told, events = [], [], os.path.join(out, "events.jsonl")
    if not os.path.exists(events):
        return way, [done.stderr.strip()]
    # TRANS is part of the tables, and no other frame is active: positions are those of the machine.
    with open(events, encoding="utf-8") as file:
        for event in map(json.loads, file):
            if event["kind"] == "motion":
                at = [event["to"].get(axis) for axis in axes]
                if not way or way[-1] != at:
                    way.append(at)
            elif event["kind"] == "diagnostic":
                told.append(event["text"])
    return way, told


def difference(axes, own, table):
    """The first position that differs. Tables begin with what is programmed, which may be where the axes are."""
    start = [{**HOME, "A": 0, "C": 0}.get(axis) for axis in axes]

    def same(at, row):
        return all(wanted is None or own is not None and abs(own - wanted) <= NEAR for own, wanted in zip(at, row))

    at, own = start, list(own)
    for number, row in enumerate(table, 1):
        if same(at, row):
            continue
        if not own:
            return f"position {number} is {row}, here the program is over"
        at = own.pop(0)
        if not same(at, row):
            return f"position {number} is {row}, here {at}"
    return f"{len(own)} more positions here" if own else ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("examples")
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--only")
    args = parser.parse_args()
    names = sorted(name[:-4] for name in os.listdir(args.examples) if name.endswith(".mpf"))
    counts, wrong = {"equal": 0, "equal as the control wants it written": 0, "refused": 0}, 0
    with tempfile.TemporaryDirectory() as folder:
        for name in names if args.only is None else [args.only]:
            axes, table = expected(os.path.join(args.examples, name + ".csv"))
            own, told = run(args, folder, name, axes)
            what = difference(axes, own, table)
            if bool(what) != (name in REFUSED):
                wrong += 1
                print(f"{name}: {what or 'equal, but listed as refused'} ({'; '.join(told)})")
                continue
            counts["refused" if what else "equal as the control wants it written" if name in ADAPTED else "equal"] += 1
    print(f"{len(names)} examples: " + ", ".join(f"{count} {what}" for what, count in counts.items()) + f", {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
