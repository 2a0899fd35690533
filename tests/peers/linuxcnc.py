#!/usr/bin/env python3
"""Runs random programs of LinuxCNC, unchanged, by rs274 (Debian package linuxcnc-uspace) and by `counterpoint run` on
the machine `linuxcnc-mill`, and compares every move: its kind, its end and its centre in machine coordinates, to 1e-6 mm.

usage: linuxcnc.py [--seeds N] [--first K] [--counterpoint BINARY] [--rs274 BINARY] [--show SEED]

Programs have O codes (sub, call, return, if, while, do, repeat, break, continue), parameters by number and with names,
expressions, lines and circles, G10 L2 and L20 with rotation, G92 and its ends, G52, G28 and G30 with stored positions,
G43, G43.1, G53, G90.1, canned cycles with G98 and G99, G76, polar words, A words, contours with cutter compensation,
both units, and the blocks of rs274.py. Words with intended differences are not generated: see
docs/coverage/linuxcnc.md.
"""
import argparse
import concurrent.futures
import os
import random
import re
import subprocess
import sys
import tempfile

import rs274
from rs274 import AXES, CENTERS, NEAR, PLANES, ROOT, difference, number

MACHINE = """extends = "linuxcnc-mill"

[ce]
name = "peer"

[[axes]]
name = "X"
rapid = 10_000

[[axes]]
name = "Y"
rapid = 10_000

[[axes]]
name = "Z"
rapid = 10_000
"""

TOOL = f"""
[[tool.offsets]]
number = 1
radius = {rs274.RADIUS}
"""


NAMES = ["a", "long name", "_g", "_Far", "b2"]


class Program:
    """A random program. Values are chosen without following positions, so expressions need not be evaluated here."""

    def __init__(self, rng):
        self.rng, self.lines, self.depth, self.label = rng, [], 0, 100
        self.names, self.subs, self.inside = list(NAMES), [], False
        # rs274 keeps circles of G18 and G19 in these planes, whatever the work offset turns.
        self.turns = rng.random() < 0.5
        # After BREAK or CONTINUE the next DO loop of rs274 ends too early.
        self.leaves = rng.random() < 0.5

    def add(self, line):
        rng = self.rng
        if rng.random() < 0.2:
            line = line.lower()
        # A comment behind an O code changes what rs274 does.
        if rng.random() < 0.1 and not line.startswith("o"):
            line = line + rng.choice([" ; a comment", " (a comment)", "  "])
        self.lines.append(line)

    def value(self, low=-80.0, high=80.0):
        return round(self.rng.uniform(low, high), self.rng.choice([0, 1, 2, 3, 4]))

    def parameter(self):
        rng = self.rng
        if self.names and rng.random() < 0.4:
            return f"#<{rng.choice(self.names)}>"
        return f"#{rng.randint(1, 8) if rng.random() < 0.5 else rng.randint(31, 40)}"

    def operand(self, deep=0):
        rng = self.rng
        kind = rng.random()
        if kind < 0.4 or deep > 2:
            return number(self.value(0, 20))
        if kind < 0.7:
            return self.parameter()
        if kind < 0.8:
            return f"{rng.choice(['ABS', 'FIX', 'FUP', 'ROUND', 'SIN', 'COS'])}[{self.sum(deep + 1)}]"
        if kind < 0.85:
            return f"ATAN[{self.sum(deep + 1)}]/[{self.sum(deep + 1)}]"
        return f"[{self.sum(deep + 1)}]"

    def sum(self, deep=0):
        rng = self.rng
        text = self.operand(deep)
        for _ in range(rng.randint(0, 2)):
            sign = rng.choice(["+", "-", "*", "+", "-", " MOD "])
            right = number(self.value(1, 9)) if sign in ("*", " MOD ") else self.operand(deep)
            text = f"{text}{sign}{right}"
        return text

    def condition(self):
        rng = self.rng
        one = lambda: f"{self.sum(1)} {rng.choice(['GT', 'LT', 'GE', 'LE', 'EQ', 'NE'])} {self.sum(1)}"
        return one() if rng.random() < 0.7 else f"[{one()}] {rng.choice(['AND', 'OR', 'XOR'])} [{one()}]"

    def word(self, letter, low=-80.0, high=80.0):
        """A word whose value is bounded, whatever the parameters are."""
        rng = self.rng
        if rng.random() < 0.75:
            return f"{letter}{number(self.value(low, high))}"
        inside = f"[{self.sum()}] MOD {number(self.value(5, 70))}"
        sign = "-" if rng.random() < 0.3 else ""
        return f"{letter}{sign}[{inside}]"

    def axes(self, least=1):
        rng = self.rng
        return " ".join(self.word(AXES[a]) for a in sorted(rng.sample(range(3), rng.randint(least, 3))))

    def assign(self):
        rng = self.rng
        if rng.random() < 0.3:
            self.add(f"#<{rng.choice(NAMES)}>=[[{self.sum()}] MOD 97]")
            return
        targets = " ".join(f"#{rng.randint(1, 8) if rng.random() < 0.5 else rng.randint(31, 40)}=[[{self.sum()}] MOD 101]"
                           for _ in range(rng.randint(1, 2)))
        self.add(targets)

    def line(self):
        code = self.rng.choice(["G0 ", "G1 ", "G1 ", ""])
        if code == "" and not self.moving:
            code = "G1 "
        self.moving = True
        kind = self.rng.random()
        if kind < 0.08:
            self.add(f"{code}{self.word('@', 1, 60)} {self.word('^', -180, 180)}")
            return
        self.add(code + self.axes() + (" " + self.word("A", -400, 400) if kind < 0.14 else ""))

    moving = False

    def circle(self):
        rng = self.rng
        plane = "G17" if self.turns else rng.choice(list(PLANES))
        first, second, third = PLANES[plane]
        code = rng.choice(["G2", "G3"])
        self.moving = False
        if rng.random() < 0.5:
            helix = f" {self.word(AXES[third])}" if rng.random() < 0.3 else ""
            turns = f" P{rng.randint(1, 3)}" if rng.random() < 0.3 else ""
            i, j = self.value(2, 40), self.value(-40, 40)
            self.add(f"{plane} G91.1 {code}{helix} {CENTERS[first]}{number(i)} {CENTERS[second]}{number(j)}{turns}")
        else:
            x, y = self.value(1, 30), self.value(1, 30)
            size = round(rng.uniform(0.8, 3) * (x * x + y * y) ** 0.5, 3) * rng.choice([1, 1, -1])
            self.add("G91")
            self.add(f"{plane} {code} {AXES[first]}{number(x)} {AXES[second]}{number(y)} R{number(size)}")
            self.add("G90")
        if plane != "G17":
            self.add("G17")

    def offset(self):
        rng = self.rng
        kind = rng.random()
        self.moving = False
        if kind < 0.25:
            turn = f" R{number(self.value(-180, 180))}" if self.turns and rng.random() < 0.3 else ""
            self.add(f"G10 L2 P{rng.randint(0, 9)} {self.axes()}{turn}")
            if self.turns:
                # rs274 keeps a wrong position if the active work offset turns.
                self.add(f"G0 {self.axes(3)}")
        elif kind < 0.4:
            self.add(f"G10 L20 P{rng.randint(0, 9)} {self.axes()}")
        elif kind < 0.55:
            self.add(rng.choice(["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]))
        elif kind < 0.7:
            self.add(f"G92 {self.axes()}")
        elif kind < 0.8:
            self.add(rng.choice(["G92.1", "G92.2", "G92.3"]))
        elif kind < 0.85:
            self.add(f"G52 {self.axes()}")
        elif kind < 0.92:
            self.add(f"G90 G53 {rng.choice(['G0', 'G1'])} {self.axes()}")
        elif kind < 0.96:
            self.add(rng.choice(["G28.1", "G30.1"]))
        else:
            self.add(rng.choice(["G28", "G30", f"G28 {self.axes()}", f"G30 {self.axes()}"]))

    def length(self):
        rng = self.rng
        self.moving = False
        self.add(rng.choice([f"G43.1 Z{number(self.value(0, 30))}", "G49", "G43 H1"]))

    def peck(self):
        """A depth that no hole is a multiple of."""
        return round(self.rng.uniform(1, 6), 3) + 0.00037

    def cycle(self):
        rng = self.rng
        self.moving = False
        code = rng.choice(["G81", "G82", "G83", "G73", "G85"])
        level = rng.choice(["G98", "G99"])
        if code == "G85":
            level = "G99"
        extra = {"G82": " P.2", "G83": f" Q{number(self.peck())}", "G73": f" Q{number(self.peck())}"}.get(code, "")
        if rng.random() < 0.4:
            self.add("G91")
            self.add(f"{level} {code} X{number(self.value(-9, 9))} Y{number(self.value(-9, 9))} Z-{number(self.value(1, 30))} "
                     f"R{number(self.value(-3, 5))}{extra} L{rng.randint(1, 3)}")
            for _ in range(rng.randint(0, 2)):
                self.add(f"{rng.choice('XY')}{number(self.value(-9, 9))}")
            self.add("G90")
        else:
            clear = self.value(0, 20)
            self.add(f"{level} {code} X{number(self.value())} Y{number(self.value())} Z{number(clear - self.value(1, 40))} "
                     f"R{number(clear)}{extra}")
            for _ in range(rng.randint(0, 3)):
                self.add(" ".join(self.word(a) for a in rng.choice([("X",), ("Y",), ("X", "Y")])))
        self.add("G80")

    def thread(self):
        rng = self.rng
        self.moving = False
        first = round(rng.uniform(0.2, 0.6), 2)
        way = rng.choice([-1, 1]) * round(rng.uniform(15, 60), 2)
        words = f"P1.5 Z{number(way)} I{rng.choice(['', '-'])}{rng.randint(1, 3)} J{number(first)} K{number(first * rng.randint(2, 4))}"
        for word in (f"R{number(round(rng.uniform(1, 2), 2))}", f"Q{rng.randint(1, 30)}", f"H{rng.randint(0, 2)}",
                     f"E{number(round(rng.uniform(1, 5), 1))} L{rng.randint(0, 3)}"):
            if rng.random() < 0.5:
                words += f" {word}"
        self.lines += ["G18 S500 M3 G91", f"G76 {words}", "G17 G90"]

    def mode(self):
        self.moving = False
        rng = self.rng
        kind = rng.random()
        if kind < 0.4:
            self.add("G91")
            for _ in range(rng.randint(1, 3)):
                self.add(f"{rng.choice(['G0', 'G1'])} {self.axes()}")
            self.add("G90")
        elif kind < 0.6:
            self.add("G20")
            self.add(f"G1 F{rng.randint(5, 40)} X{number(round(self.value() / 25.4, 4))} Y{number(round(self.value() / 25.4, 4))}")
            self.add("G21 F500")
        elif kind < 0.8:
            self.add(f"G1 {self.word('X')} G4 P.1")
        else:
            self.add(f"G90.1 G1 {self.word('X')}")
            self.add("G91.1")

    def flow(self):
        rng = self.rng
        self.label += 1
        label, kind = f"o{self.label}", rng.random() * (0.8 if self.leaves else 1)
        self.depth += 1
        if kind < 0.35:
            self.add(f"{label} if [{self.condition()}]")
            self.some()
            if rng.random() < 0.4:
                self.add(f"{label} elseif [{self.condition()}]")
                self.some()
            if rng.random() < 0.5:
                self.add(f"{label} else")
                self.some()
            self.add(f"{label} endif")
        elif kind < 0.6:
            self.add(f"{label} repeat [{rng.randint(0, 3)}]")
            self.some()
            self.add(f"{label} endrepeat")
        else:
            count = f"#{self.label + 200}"
            self.add(f"{count}=0")
            self.add(f"{label} while [{count} LT {rng.randint(1, 4)}]" if kind < 0.8 else f"{label} do")
            self.add(f"{count}=[{count}+1]")
            self.some()
            if kind < 0.8 and self.leaves:
                self.label += 1
                self.add(f"o{self.label} if [{self.condition()}]")
                self.add(f"{label} {rng.choice(['break', 'continue'])}")
                self.add(f"o{self.label} endif")
            self.add(f"{label} endwhile" if kind < 0.8 else f"{label} while [{count} LT {rng.randint(1, 4)}]")
        self.depth -= 1
        self.moving = False

    def call(self):
        rng = self.rng
        if not self.subs:
            return self.line()
        name = rng.choice(self.subs)
        arguments = " ".join(f"[[{self.sum()}] MOD 50]" for _ in range(rng.randint(0, 4)))
        self.add(f"o{name} call {arguments}")
        if rng.random() < 0.5:
            self.add("G0 X[#<_value> MOD 40] Y[#<_value_returned>*5]")
        self.moving = False

    def some(self):
        for _ in range(self.rng.randint(1, 3)):
            self.one()

    def one(self):
        kind = self.rng.random()
        if kind < 0.3:
            self.line()
        elif kind < 0.45:
            self.assign()
        elif kind < 0.55:
            self.circle()
        elif kind < 0.68:
            self.offset()
        elif kind < 0.75:
            self.cycle()
        elif kind < 0.82:
            self.mode()
        elif kind < 0.85:
            self.length()
        elif kind < 0.86 and not self.turns:
            self.thread()
        elif kind < 0.9:
            self.call()
        elif self.depth < 3:
            self.flow()
        else:
            self.line()

    def sub(self, name):
        rng = self.rng
        self.add(f"o{name} sub")
        self.define([name for name in NAMES if not name.startswith("_")])
        self.moving = False
        self.some()
        if rng.random() < 0.4:
            self.label += 1
            self.add(f"o{self.label} if [{self.condition()}]")
            self.add(f"o{name} return" + rng.choice(["", f" [[{self.sum()}] MOD 30]"]))
            self.add(f"o{self.label} endif")
        self.some()
        # rs274 evaluates this value when it passes the definition, too, so it is always there.
        self.add(f"o{name} endsub [[{self.sum()}] MOD 30]")

    def define(self, names):
        for name in names:
            self.lines.append(f"#<{name}>={number(self.value())}")

    def made(self):
        rng = self.rng
        self.define(NAMES)
        self.lines += ["G21 G17 G90 G94 G40 G49 G80 G98", "F500"]
        for n in range(1, 10):
            self.lines.append(f"G10 L2 P{n} X{number(self.value())} Y{number(self.value())} Z{number(self.value())} R0")
        self.lines += ["G92.1", "G54", "G10 L1 P1 Z12.5", "G0 X0 Y0 Z0", "G28.1", "G30.1"]
        for number_ in range(31, 41):
            self.lines.append(f"#{number_}={number(self.value())}")
        for name in ("10", "<deep>"):
            self.sub(name)
            self.subs.append(name)
        self.moving = False
        for _ in range(rng.randint(10, 40)):
            self.one()
        if not self.turns and rng.random() < 0.2:
            self.lines += ["G54 G92.1 G40 G94 F500", *rs274.contour(rng)]
        return self.lines


def program(seed):
    return Program(random.Random(seed)).made()


def peer_moves(args, folder, name, lines):
    """Moves of rs274 with the tool offset and the rotation of the work offset."""
    try:
        done = rs274.run_peer(args, folder, name, lines, timeout=2)
    except subprocess.TimeoutExpired:
        return None, "rs274 does not end"
    if "PROGRAM_END" not in done.stdout:
        return None, (done.stdout[-300:] + done.stderr[-300:])
    return moves_of(done.stdout), ""


def moves_of(text, at=None):
    from math import cos, radians, sin
    work, shift, tool, angle, plane, unit, moves = [0.0] * 3, [0.0] * 3, [0.0] * 3, 0.0, "XY", 1.0, []

    def machine(point):
        x, y, z = (p + s for p, s in zip(point, shift))
        c, s = cos(radians(angle)), sin(radians(angle))
        return [a + b + t for a, b, t in zip((x * c - y * s, x * s + y * c, z), work, tool)]

    last = [0.0] * 3
    for line in text.splitlines():
        found = re.search(r"([A-Z0-9_]+)\((.*)\)$", line)
        if not found:
            continue
        name, values = found.groups()
        if name == "SELECT_PLANE":
            plane = values[-2:]
        elif name == "USE_LENGTH_UNITS":
            unit = 25.4 if "INCHES" in values else 1.0
        elif name == "SET_G5X_OFFSET":
            work = [float(v) * unit for v in values.split(",")[1:4]]
        elif name == "SET_G92_OFFSET":
            shift = [float(v) * unit for v in values.split(",")[:3]]
        elif name == "SET_XY_ROTATION":
            angle = float(values)
        elif name == "USE_TOOL_LENGTH_OFFSET":
            tool = [float(v) * unit for v in values.replace(",", " ").split()[:3]]
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "STRAIGHT_PROBE"):
            last = [float(v) * unit for v in values.split(",")[:3]]
            to = machine(last)
            if at is None or max(abs(a - b) for a, b in zip(at, to)) > NEAR / 10:
                moves.append(("rapid" if name == "STRAIGHT_TRAVERSE" else "feed", to))
            at = to
        elif name == "ARC_FEED":
            v = [float(v) for v in values.split(",")]
            first, second, third = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}[plane]
            point = list(last)
            point[first], point[second], point[third] = v[0] * unit, v[1] * unit, v[5] * unit
            middle = list(point)
            middle[first], middle[second] = v[2] * unit, v[3] * unit
            to, center = machine(point), machine(middle)
            moves.append(("ccw" if v[4] > 0 else "cw", to + [center[first], center[second]]))
            last, at = point, to
    return moves


def compare(args, folder, seed):
    lines = program(seed)
    peer, why = peer_moves(args, folder, f"p{seed}", lines)
    if peer is None:
        return seed, "refused", why
    own, told = rs274.own_moves(args, folder, f"p{seed}", lines, "M2")
    what = difference(own, peer)
    rs274.remove(folder, seed)
    return seed, "different" if what else "equal", what + (f" ({told})" if what and told else "")


def show(args, folder):
    lines = program(args.show)
    print("\n".join(lines))
    for moves, why in (rs274.own_moves(args, folder, "shown", lines, "M2"), peer_moves(args, folder, "shown", lines)):
        print("---", why)
        for kind, values in moves or []:
            print(kind, *(f"{v:.7f}" for v in values))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=300)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--rs274", default="rs274")
    parser.add_argument("--show", type=int)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rs274.prepare(folder, MACHINE + TOOL)
        if args.show is not None:
            return show(args, folder)
        counts = {"equal": 0, "different": 0, "refused": 0}
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for seed, verdict, what in pool.map(lambda seed: compare(args, folder, seed), range(args.first, args.first + args.seeds)):
                counts[verdict] += 1
                if verdict == "different":
                    print(f"seed {seed}: {what}", flush=True)
        print(f"{args.seeds} programs of LinuxCNC: " + ", ".join(f"{n} {what}" for what, n in counts.items()))
        return 1 if counts["different"] else 0


if __name__ == "__main__":
    sys.exit(main())
