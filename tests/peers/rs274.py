#!/usr/bin/env python3
"""Runs random milling programs by rs274 (LinuxCNC, Debian package linuxcnc-uspace) and by `counterpoint run`, and
compares every move: its kind, its end and its centre in machine coordinates, to 1e-6 mm.

usage: rs274.py [--seeds N] [--first K] [--compensated] [--counterpoint BINARY] [--rs274 BINARY] [--show SEED]

Plain programs have straight moves, circles by centre and by radius in all planes, helices, absolute and incremental
words, work offsets, G92 or G52, G53, drilling cycles, variables and expressions. With --compensated they are contours
with cutter compensation that begin with a straight lead-in. `--show` prints one program and both lists of moves.

rs274 prints four digits; a preloaded library, compiled by cc, makes it print ten. Both machines are made to mean the
same where the controls differ by a parameter (see MACHINE). What remains different for a reason is not generated:

* values at addresses are rounded on the Fanuc, not here (`expressions = "exact"`); MOD of negative numbers;
* outside corners are arcs in rs274 (`corner = "arc"`); its lead-in ends square to itself, on the Fanuc square to the
  next move, so the lead-in goes on straight into the contour;
* rs274 makes no arc at an outside corner of less than about half a degree, so corners are larger;
* peck drilling returns to 0.254 mm above the last depth in rs274; the clearance of the Fanuc is a parameter;
* after feeding out of a hole (G85, G89) rs274 goes on at feed to the initial level, the Fanuc at rapid from the R level;
* a drilling cycle that begins below its R level first goes up in rs274;
* G92 and G52 share their offset in rs274, so a program has one of them alone.

A program that rs274 refuses (a contour too narrow for the tool) is counted and left out.
"""
import argparse
import concurrent.futures
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
NEAR = 1e-6
RADIUS = 3.0

MACHINE = f"""extends = "fanuc-mill"

[ce]
name = "peer"

[control]
expressions = "exact"

[compensation]
corner = "arc"

[[axes]]
name = "Z"
rapid = 20_000
home = 0

[[tool.offsets]]
number = 1
radius = {RADIUS}
"""

PRELOAD = r"""
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
static const char *longer(const char *format, char *room, size_t size) {
    size_t out = 0;
    for (const char *at = format; *at && out + 8 < size;) {
        if (strncmp(at, "%.4f", 4) == 0) { memcpy(room + out, "%.10f", 5); out += 5; at += 4; }
        else room[out++] = *at++;
    }
    room[out] = 0;
    return room;
}
int __vfprintf_chk(FILE *file, int flag, const char *format, va_list list) {
    char room[4096];
    (void)flag;
    return vfprintf(file, longer(format, room, sizeof room), list);
}
int __fprintf_chk(FILE *file, int flag, const char *format, ...) {
    va_list list;
    va_start(list, format);
    int done = __vfprintf_chk(file, flag, format, list);
    va_end(list);
    return done;
}
int __printf_chk(int flag, const char *format, ...) {
    va_list list;
    va_start(list, format);
    int done = __vfprintf_chk(stdout, flag, format, list);
    va_end(list);
    return done;
}
"""

PLANES = {"G17": (0, 1, 2), "G18": (2, 0, 1), "G19": (1, 2, 0)}
AXES = "XYZ"
CENTERS = "IJK"


def number(value):
    text = f"{value:.10f}".rstrip("0")
    return "0." if text in ("-0.", "0.") else text


class Plain:
    """A random program; `at` is the position of the program, kept up to move after move."""

    def __init__(self, rng):
        self.rng, self.lines, self.at = rng, [], [0.0, 0.0, 0.0]
        self.plane, self.relative, self.motion = "G17", False, None
        self.shifts = rng.choice(["G92", "G52"])
        self.variables, self.name = {}, 101

    def value(self, low=-80.0, high=80.0):
        return round(self.rng.uniform(low, high), self.rng.choice([0, 1, 2, 3, 4]))

    def word(self, letter, value):
        """A word with a value, as a number or by a variable or an expression."""
        kind = self.rng.random()
        if kind < 0.85:
            return f"{letter}{number(value)}"
        if kind < 0.92:
            self.name = 101 + (self.name - 100) % 30
            name = self.name
            self.lines.append(f"#{name}={number(value)}")
            return f"{letter}#{name}"
        part = self.value()
        return f"{letter}[{number(value - part)}+{number(part)}]"

    def words(self, target, axes):
        return [self.word(AXES[a], target[a] - self.at[a] if self.relative else target[a]) for a in axes]

    def expression(self):
        """A number and a way to write it."""
        rng = self.rng
        if rng.random() < 0.4 or not self.variables:
            value = self.value()
            return value, number(value) if value >= 0 else f"[{number(value)}]"
        name = rng.choice(list(self.variables))
        return self.variables[name], f"#{name}"

    def assign(self):
        rng = self.rng
        (a, x), (b, y) = self.expression(), self.expression()
        made = rng.choice([
            lambda: (a + b * 0.5, f"{x}+{y}*0.5"), lambda: ((a - b) / 4, f"[{x}-{y}]/4"),
            lambda: (20 * math.sin(math.radians(a)), f"20*SIN[{x}]"), lambda: (20 * math.cos(math.radians(b)), f"20*COS[{y}]"),
            lambda: (math.sqrt(abs(a)), f"SQRT[ABS[{x}]]"), lambda: (float(math.floor(abs(a))), f"FIX[ABS[{x}]]"),
            lambda: (float(math.ceil(abs(b))), f"FUP[ABS[{y}]]"), lambda: (abs(a) / 2, f"ABS[{x}]/2"),
            lambda: (math.degrees(math.atan2(abs(a), abs(b) + 1)), f"ATAN[ABS[{x}]]/[ABS[{y}]+1]"),
        ])
        value, text = made()
        name = rng.randint(131, 160)
        self.lines.append(f"#{name}=[{text}]")
        self.variables[name] = value

    def straight(self):
        rng = self.rng
        axes = sorted(rng.sample(range(3), rng.randint(1, 3)))
        target = list(self.at)
        for axis in axes:
            target[axis] = self.value()
        words = self.words(target, axes)
        if self.variables and rng.random() < 0.3:
            name = rng.choice(list(self.variables))
            axis = axes[0]
            words[0] = f"{AXES[axis]}#{name}"
            target[axis] = self.variables[name] + (self.at[axis] if self.relative else 0.0)
        motion = rng.choice(["G0", "G1"])
        code = [] if motion == self.motion and rng.random() < 0.5 else [motion]
        self.lines.append(" ".join(code + words))
        self.motion, self.at = motion, target

    def circle(self):
        rng = self.rng
        first, second, third = PLANES[self.plane]
        target = list(self.at)
        helix = rng.random() < 0.3
        if helix:
            target[third] = self.value()
        clockwise = rng.random() < 0.5
        code = "G2" if clockwise else "G3"
        if rng.random() < 0.5:
            size, begin = rng.uniform(2, 40), rng.uniform(0, 2 * math.pi)
            way = rng.choice([2 * math.pi, rng.uniform(0.1, 6.1)])
            center = [round(-size * math.cos(begin), 5), round(-size * math.sin(begin), 5)]
            size, begin = math.hypot(*center), math.atan2(-center[1], -center[0])
            end = begin + (-way if clockwise else way)
            if way < 6.2:
                target[first] = round(self.at[first] + center[0] + size * math.cos(end), 7)
                target[second] = round(self.at[second] + center[1] + size * math.sin(end), 7)
            axes = [first, second] if way < 6.2 or rng.random() < 0.5 else []
            words = self.words(target, sorted(axes + ([third] if helix else [])))
            words += [f"{CENTERS[a]}{number(c)}" for a, c in zip((first, second), center)]
        else:
            chord, heading = rng.uniform(1, 40), rng.uniform(0, 2 * math.pi)
            target[first] = round(self.at[first] + chord * math.cos(heading), 4)
            target[second] = round(self.at[second] + chord * math.sin(heading), 4)
            size = round(chord / 2 * rng.uniform(1.05, 3), 3) * rng.choice([1, 1, -1])
            words = self.words(target, sorted([first, second] + ([third] if helix else [])))
            words.append(f"R{number(size)}")
        self.lines.append(" ".join([code] + words))
        self.motion, self.at = code, target

    def mode(self):
        self.relative = self.rng.random() < 0.4
        self.lines.append("G91" if self.relative else "G90")

    def known(self):
        """Back to a known position, in some programs after a distance that starts from the unknown one."""
        rng = self.rng
        if rng.random() < 0.5:
            self.lines.append(f"G91 G0 X{number(self.value())} Z{number(self.value())}")
        self.at = [self.value() for _ in AXES]
        self.relative, self.motion = False, "G0"
        self.lines.append("G90 G0 " + " ".join(f"{a}{number(v)}" for a, v in zip(AXES, self.at)))

    def offset(self):
        rng = self.rng
        kind = rng.random()
        axes = sorted(rng.sample(range(3), rng.randint(1, 3)))
        words = " ".join(f"{AXES[a]}{number(self.value())}" for a in axes)
        if kind < 0.3:
            self.lines.append(f"G90 G10 L2 P{rng.randint(1, 6)} {words}")
        elif kind < 0.6:
            self.lines.append(f"G{rng.randint(54, 59)}")
        elif kind < 0.8:
            self.lines.append(f"G90 {self.shifts} X{number(self.value())} Y{number(self.value())} Z{number(self.value())}")
        else:
            self.lines.append(f"G90 G53 {rng.choice(['G0', 'G1'])} {words}")
        self.known()

    def drill(self):
        rng = self.rng
        self.lines.append("G90 G17 G80")
        self.plane, self.relative = "G17", False
        top = round(rng.uniform(30, 60), 2)
        clear, bottom = round(top - rng.uniform(1, 20), 2), round(rng.uniform(-60, 5), 3)
        x, y = self.value(), self.value()
        self.lines.append(f"G0 X{number(x)} Y{number(y)} Z{number(top)}")
        code = rng.choice(["G81", "G82", "G85", "G89"])
        level = rng.choice(["G98", "G99"]) if code in ("G81", "G82") else "G99"
        dwell = " P.2" if code in ("G82", "G89") else ""
        if rng.random() < 0.3:
            step = [self.value(-9, 9), self.value(-9, 9)]
            count = rng.randint(1, 4)
            self.lines.append(f"G91 {level} {code} X{number(step[0])} Y{number(step[1])} Z{number(bottom - clear)} "
                              f"R{number(clear - top)}{dwell} L{count} F200")
            x, y = x + step[0] * count, y + step[1] * count
            self.lines.append("G90")
        else:
            x, y = self.value(), self.value()
            self.lines.append(f"{level} {code} X{number(x)} Y{number(y)} Z{number(bottom)} R{number(clear)}{dwell} F200")
            for _ in range(rng.randint(0, 4)):
                if rng.random() < 0.5:
                    x = self.value()
                    self.lines.append(f"X{number(x)}")
                else:
                    x, y = self.value(), self.value()
                    self.lines.append(f"X{number(x)} Y{number(y)}")
        self.lines.append("G80")
        self.at, self.motion = [x, y, top if level == "G98" else clear], None

    def made(self):
        rng = self.rng
        for n in range(1, 7):
            self.lines.append(f"G10 L2 P{n} X{number(self.value())} Y{number(self.value())} Z{number(self.value())}")
        self.lines.append("G54")
        self.known()
        for _ in range(rng.randint(10, 40)):
            kind = rng.random()
            if kind < 0.35:
                self.straight()
            elif kind < 0.65:
                self.circle()
            elif kind < 0.72:
                self.mode()
            elif kind < 0.80:
                self.plane = rng.choice(list(PLANES))
                self.lines.append(self.plane)
            elif kind < 0.88:
                self.assign()
            elif kind < 0.95:
                self.offset()
            else:
                self.drill()
        return self.lines


def contour(rng):
    """A contour beside which the tool goes, with a straight lead-in."""
    heading = rng.uniform(0, 2 * math.pi)
    at = [round(rng.uniform(-50, 50), 3), round(rng.uniform(-50, 50), 3)]

    def onward(way, direction):
        at[0] = round(at[0] + way * math.cos(direction), 10)
        at[1] = round(at[1] + way * math.sin(direction), 10)
        return f"X{number(at[0])} Y{number(at[1])}"

    lines = ["T1 M6", f"G0 X{number(at[0])} Y{number(at[1])} Z2.", "G1 Z-3. F300."]
    lines.append(f"{rng.choice(['G41', 'G42'])} D1 G1 {onward(rng.uniform(8, 30), heading)}")
    lines.append(f"G1 {onward(rng.uniform(15, 60), heading)}")
    for _ in range(rng.randint(3, 15)):
        heading += math.radians(rng.choice([-1, 1]) * rng.uniform(12, 125))
        if rng.random() < 0.65:
            depth = f" Z{number(round(rng.uniform(-9, -1), 2))}" if rng.random() < 0.15 else ""
            lines.append(f"G1 {onward(rng.uniform(15, 60), heading)}{depth}")
            continue
        size, way, clockwise = rng.uniform(9, 40), rng.uniform(0.5, 4.5), rng.random() < 0.5
        turn = -1 if clockwise else 1
        side = heading + turn * math.pi / 2
        center = [round(size * math.cos(side), 5), round(size * math.sin(side), 5)]
        start = math.atan2(-center[1], -center[0])
        size = math.hypot(*center)
        middle = [at[0] + center[0], at[1] + center[1]]
        end = start + turn * way
        at[:] = [round(middle[0] + size * math.cos(end), 10), round(middle[1] + size * math.sin(end), 10)]
        lines.append(f"{'G2' if clockwise else 'G3'} X{number(at[0])} Y{number(at[1])} I{number(center[0])} J{number(center[1])}")
        heading = end + turn * math.pi / 2
    lines.append(f"G40 G1 {onward(rng.uniform(10, 40), heading + rng.uniform(-1, 1))}")
    return lines + ["G0 Z20."]


def program(seed, compensated):
    rng = random.Random(seed)
    lines = contour(rng) if compensated else Plain(rng).made()
    return ["G21 G17 G90 G94 G40 G49 G80 G98", "F500", *lines]


def run_peer(args, folder, name, lines, timeout=None):
    """Runs a program by rs274."""
    path = os.path.join(folder, name + ".ngc")
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join([*lines, "M2"]) + "\n")
    store = path + ".var"
    with open(store, "w", encoding="ascii") as file:
        numbers = [5161, 5162, 5163, 5164, 5165, 5166, 5167, 5168, 5169, 5181, 5182, 5183, 5184, 5185, 5186, 5187, 5188, 5189]
        numbers += list(range(5210, 5220))
        numbers += [n + k for n in range(5221, 5401, 20) for k in range(10)]
        rows = {**{n: 0 for n in numbers}, 5220: 1}
        file.writelines(f"{n}\t{rows[n]}.000000\n" for n in sorted(rows))
    # It keeps its tools in a file of the home folder that all its processes share.
    home = path + ".home"
    os.makedirs(home, exist_ok=True)
    done = subprocess.run([args.rs274, "-t", os.path.join(folder, "tool.tbl"), "-v", store, "-g", path],
                          env={**os.environ, "LD_PRELOAD": os.path.join(folder, "digits.so"), "HOME": home},
                          capture_output=True, text=True, check=False, cwd=folder, timeout=timeout)
    shutil.rmtree(home)
    return done


def peer_moves(args, folder, name, lines):
    """Moves of rs274 in machine coordinates; none if it refuses the program."""
    done = run_peer(args, folder, name, lines)
    if "PROGRAM_END" not in done.stdout:
        return None, (done.stdout[-300:] + done.stderr[-300:])
    moves, work, shift, plane, at = [], [0.0] * 3, [0.0] * 3, "XY", None
    for line in done.stdout.splitlines():
        found = re.search(r"([A-Z0-9_]+)\((.*)\)$", line)
        if not found:
            continue
        name, values = found.groups()
        if name == "SELECT_PLANE":
            plane = values[-2:]
        elif name == "SET_G5X_OFFSET":
            work = [float(v) for v in values.split(",")[1:4]]
        elif name == "SET_G92_OFFSET":
            shift = [float(v) for v in values.split(",")[:3]]
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            to = [float(v) + w + s for v, w, s in zip(values.split(","), work, shift)]
            if at is None or max(abs(a - b) for a, b in zip(at, to)) > NEAR / 10:
                moves.append(("rapid" if name == "STRAIGHT_TRAVERSE" else "feed", to))
            at = to
        elif name == "ARC_FEED":
            v = [float(v) for v in values.split(",")]
            first, second, third = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}[plane]
            move = [work[a] + shift[a] for a in range(3)]
            to, center = list(move), [0.0] * 2
            to[first], to[second], to[third] = to[first] + v[0], to[second] + v[1], to[third] + v[5]
            center = [move[first] + v[2], move[second] + v[3]]
            moves.append(("ccw" if v[4] > 0 else "cw", to + center))
            at = to
    return moves, ""


def own_moves(args, folder, name, lines, end="M30"):
    path, out = os.path.join(folder, name + ".nc"), os.path.join(folder, name)
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join([*lines, end]) + "\n")
    machine = os.path.join(folder, "peer")
    done = subprocess.run([args.counterpoint, "run", "--quiet", "--machine", machine, "--out", out, "--write", "events", path],
                          capture_output=True, text=True, check=False)
    moves, shift, told = [], [0.0] * 3, []
    with open(os.path.join(out, "events.jsonl"), encoding="utf-8") as file:
        for event in map(json.loads, file):
            kind = event["kind"]
            if kind == "frame":
                shift = [event["shift"][a] for a in AXES]
            elif kind == "diagnostic":
                told.append(event["text"])
            elif kind == "motion":
                ends = [[event[end][a] + s for a, s in zip(AXES, shift)] for end in ("from", "to")]
                if "center" in event:
                    first, second, _ = next(p for p in PLANES.values() if {AXES[p[0]], AXES[p[1]]} == set(event["center"]))
                    center = [event["center"][AXES[a]] + shift[a] for a in (first, second)]
                    moves.append((event["motion"][4:], ends[1] + center))
                elif max(abs(a - b) for a, b in zip(*ends)) > NEAR / 10:
                    moves.append(("rapid" if event["motion"] == "rapid" else "feed", ends[1]))
    return moves, "; ".join(told) + done.stderr[-200:]


def difference(own, peer):
    for at, (a, b) in enumerate(zip(own, peer)):
        if a[0] != b[0] or max(abs(x - y) for x, y in zip(a[1], b[1])) > NEAR:
            return f"move {at + 1}: {a} here, {b} in rs274"
    return "" if len(own) == len(peer) else f"{len(own)} moves here, {len(peer)} in rs274"


def compare(args, folder, seed):
    lines = program(seed, args.compensated)
    peer, why = peer_moves(args, folder, f"p{seed}", lines)
    if peer is None:
        return seed, "refused", why
    own, told = own_moves(args, folder, f"p{seed}", lines)
    what = difference(own, peer)
    remove(folder, seed)
    return seed, "different" if what else "equal", what + (f" ({told})" if what and told else "")


def remove(folder, seed):
    """Removes the files of a program."""
    for ending in (".ngc", ".nc", ".ngc.var", ".ngc.var.bak", "/events.jsonl"):
        if os.path.exists(os.path.join(folder, f"p{seed}{ending}")):
            os.remove(os.path.join(folder, f"p{seed}{ending}"))


def show(args, folder):
    lines = program(args.show, args.compensated)
    print("\n".join(lines))
    for side in (own_moves, peer_moves):
        moves, why = side(args, folder, "shown", lines)
        print(f"--- {side.__name__} {why}")
        for kind, values in moves or []:
            print(kind, *(f"{v:.7f}" for v in values))


def prepare(folder, machine):
    """Puts into the folder what both interpreters need: the machine, the tool table, and the library for more digits."""
    os.mkdir(os.path.join(folder, "peer"))
    for name, text in [("peer/machine.toml", machine), ("tool.tbl", f"T1 P1 Z0 D{2 * RADIUS / 25.4:.12f}\n"), ("digits.c", PRELOAD)]:
        with open(os.path.join(folder, name), "w", encoding="ascii") as file:
            file.write(text)
    source, library = os.path.join(folder, "digits.c"), os.path.join(folder, "digits.so")
    subprocess.run(["cc", "-shared", "-fPIC", "-U_FORTIFY_SOURCE", "-o", library, source], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=300)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--compensated", action="store_true")
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--rs274", default="rs274")
    parser.add_argument("--show", type=int)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        prepare(folder, MACHINE)
        if args.show is not None:
            return show(args, folder)
        counts = {"equal": 0, "different": 0, "refused": 0}
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            seeds = range(args.first, args.first + args.seeds)
            for seed, verdict, what in pool.map(lambda seed: compare(args, folder, seed), seeds):
                counts[verdict] += 1
                if verdict == "different":
                    print(f"seed {seed}: {what}", flush=True)
        kind = "compensated" if args.compensated else "plain"
        print(f"{args.seeds} {kind} programs: " + ", ".join(f"{n} {what}" for what, n in counts.items()))
        return 1 if counts["different"] else 0


if __name__ == "__main__":
    sys.exit(main())
