#!/usr/bin/env python3
"""Runs random turning cycles by rs274 (LinuxCNC, Debian package linuxcnc-uspace) and by `counterpoint run` on a lathe of the
Fanuc kind, and compares the cuts that both controls define alike, to 1e-6 mm.

usage: turning.py [--seeds N] [--first K] [--counterpoint BINARY] [--rs274 BINARY] [--show SEED]

* G71 and G72 (G71 and G72 of rs274, contour as a subprogram): every cut along the axis, by its level and where it ends
  at the contour, and the pass along the contour behind them. Contours are straight lines and quarter circles that rise
  towards one side.
* G70: every move of the contour, circles with their centre.
* G76 of two lines (G76 of rs274 with R2 and the angle of the flank as Q): diameter and start along Z of every pass, and
  the number of passes.

What remains different for a reason is left out: rs274 also cuts at the level it starts from; it turns back 45 degrees once more
before the next cut; it ends the contour of a rough pass beside the start. The end of a thread moves along the flank in
rs274 and stays on the Fanuc. Lengths are of the radius in rs274 (G8), of the diameter here.
"""
import argparse
import json
import os
import random
import subprocess
import sys
import tempfile

import rs274
from rs274 import NEAR

MACHINE = 'extends = "fanuc-lathe"\n\n[ce]\nname = "peer"\n'
START = (30.0, 2.0)


def number(value):
    text = f"{value:.4f}".rstrip("0")
    return "0." if text == "-0." else text


class Contour:
    """A contour of G71, or of G72 with `face`, from the level of the last cut up towards the start.

    Moves are (kind, (level, along), centre from the begin of a circle). For G71 the level is the radius and the cuts run along
    Z; for G72 it is Z and they run along the radius.
    """

    def __init__(self, rng, face):
        self.face = face
        self.low = round(rng.uniform(4, 10), 3)
        at, self.moves = (self.low, round(rng.uniform(-4, 1), 3)), []
        self.moves.append(("line", at, None))
        kinds = [rng.choice(["slope", "step", "convex", "concave"]) for _ in range(rng.randint(0, 4))]
        for kind in [*kinds, "slope"]:
            size = round(rng.uniform(1, 4), 3)
            if at[0] + size > 28:
                break
            down = round(rng.uniform(0.5, 4), 3) if kind == "slope" else size
            at = (at[0] if kind == "step" else round(at[0] + size, 4), round(at[1] - down, 4))
            center = {"convex": (0.0, -size), "concave": (size, 0.0)}.get(kind)
            self.moves.append((kind if center else "line", at, center))

    def point(self, at):
        """Radius and Z of a level and a place along the cuts; both begin at START."""
        level, along = at
        return (START[0] + along - START[1], START[1] + level - START[0]) if self.face else (level, along)

    def lines(self, factor):
        """As blocks; X times `factor`."""
        codes = {"line": "G1", "convex": "G3", "concave": "G2"}
        if self.face:
            codes = {"line": "G1", "convex": "G2", "concave": "G3"}
        for kind, at, center in self.moves:
            radius, z = self.point(at)
            words = f"{codes[kind]} X{number(radius * factor)} Z{number(z)}"
            if center:
                i, k = reversed(center) if self.face else center
                words += f" I{number(i)} K{number(k)}"
            yield words


def peer_program(case):
    head = ["G8 G18 G21 G90 G94 F100"]
    if case["kind"] == "thread":
        return [*head, f"G0 X{number(case['x'])} Z{number(case['z'])}", "M3 S500",
                f"G76 P{number(case['lead'])} Z{number(case['end'])} I{number(-case['peak'])} J{number(case['first'])} "
                f"K{number(case['depth'])} R2 Q{number(case['angle'] / 2)} H{case['springs']}"]
    contour = case["contour"]
    radius, z = contour.point((contour.low, START[1]))
    return ["O100 SUB", f"G1 X{number(radius)} Z{number(z)}", *contour.lines(1), "O100 ENDSUB", *head,
            f"G0 X{number(START[0])} Z{number(START[1])}",
            f"{case['kind']} Q100 X{number(START[0])} Z{number(START[1])} I{number(case['step'])} R{number(case['back'])} D0", "G70 Q100"]


def own_program(case):
    head = ["G18 G21 G98 G97 S500 M3"]
    if case["kind"] == "thread":
        root = case["x"] - case["peak"] - case["depth"]
        return [*head, f"G0 X{number(2 * case['x'])} Z{number(case['z'])}",
                f"G76 P{case['springs']:02}00{case['angle']:02} Q0 R0",
                f"G76 X{number(2 * root)} Z{number(case['end'])} P{round(case['depth'] * 1000)} Q{round(case['first'] * 1000)} "
                f"F{number(case['lead'])}"]
    contour = case["contour"]
    radius, z = contour.point((contour.low, START[1]))
    lines, depth = list(contour.lines(2)), "W" if contour.face else "U"
    first = f"Z{number(z)}" if contour.face else f"X{number(2 * radius)}"
    return [*head, f"G0 X{number(2 * START[0])} Z{number(START[1])}",
            f"{case['kind']} {depth}{number(case['step'])} R{number(case['back'])}", f"{case['kind']} P10 Q20 U0 W0 F100.",
            f"N10 G0 {first}", f"{lines[0]} F100.", *lines[1:-1], f"N20 {lines[-1]}" if lines[1:] else "N20 G4 P1", "G70 P10 Q20"]


def case_of(seed):
    rng = random.Random(seed)
    if seed % 3 == 0:
        peak, depth = round(rng.uniform(0.5, 3), 3), round(rng.uniform(0.6, 3), 3)
        return {"kind": "thread", "x": round(rng.uniform(10, 30), 3), "z": round(rng.uniform(3, 8), 3),
                "end": round(rng.uniform(-40, -10), 3), "peak": peak, "depth": depth, "first": round(rng.uniform(0.15, 0.7) * depth, 3),
                "lead": rng.choice([1.0, 1.5, 2.0, 3.0]), "angle": rng.choice([0, 29, 30, 55, 60, 80]), "springs": rng.randint(1, 4)}
    kind = "G71" if seed % 3 == 1 else "G72"
    return {"kind": kind, "contour": Contour(rng, kind == "G72"), "step": round(rng.uniform(0.5, 4), 3), "back": round(rng.uniform(0.1, 1), 3)}


def own_moves(args, folder, name, lines):
    """Moves as (kind, from, to, centre), positions as (radius, Z)."""
    path, out = os.path.join(folder, name + ".nc"), os.path.join(folder, name)
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join([*lines, "M30"]) + "\n")
    done = subprocess.run([args.counterpoint, "run", "--quiet", "--machine", os.path.join(folder, "peer"), "--out", out, "--write", "events",
                           path], capture_output=True, text=True, check=False)
    moves, told, events = [], [done.stderr.strip()] if done.stderr.strip() else [], os.path.join(out, "events.jsonl")
    with open(events, encoding="utf-8") as file:
        for event in map(json.loads, file):
            if event["kind"] == "motion":
                ends = [(event[end]["X"] / 2, event[end]["Z"]) for end in ("from", "to")]
                center = event.get("center")
                moves.append((event["motion"].removeprefix("arc_"), *ends, (center["X"] / 2, center["Z"]) if center else None))
            elif event["kind"] == "diagnostic":
                told.append(event["text"])
    return moves, told


def peer_moves(args, folder, name, lines):
    moves, why = rs274.peer_moves(args, folder, name, lines)
    if moves is None:
        return None, why
    at, out = None, []
    for kind, values in moves:
        to = (values[0], values[2])
        center = (values[4], values[3]) if len(values) > 3 else None
        if at is not None:
            out.append((kind, at, to, center))
        at = to
    return out, why


def near(a, b):
    return (a is None) == (b is None) and (a is None or max(abs(x - y) for x, y in zip(a, b)) <= NEAR)


def parts(case, moves):
    """What both controls define alike."""
    if case["kind"] == "thread":
        starts = [start for kind, start, to, _ in moves if kind in ("feed", "thread") and abs(start[0] - to[0]) <= NEAR]
        # Where a pass hits the depth exactly, rs274 may miss it by a rounding and add one more pass there.
        exact = (case["depth"] / case["first"]) ** 2
        if abs(exact - round(exact)) < NEAR:
            starts = [start for at, start in enumerate(starts) if at == 0 or not near(start, starts[at - 1])]
        return {"passes": starts}
    contour = case["contour"]
    feeds = [(kind, start, to, center) for kind, start, to, center in moves if kind != "rapid" and not near(start, to)]
    count = len(contour.moves)
    level, low = (1, contour.point((contour.low, 0))[1]) if contour.face else (0, contour.low)
    # The cuts at one level above the last one; what follows is the contour, twice.
    rough = [(start[level], to[1 - level]) for _, start, to, center in feeds[:-count]
             if abs(start[level] - to[level]) <= NEAR and abs(start[1 - level] - START[1 - level]) <= NEAR
             and abs(start[level] - START[level]) > NEAR and abs(start[level] - low) > NEAR]
    return {"cuts": rough, "contour": [(kind, to, center) for kind, _, to, center in feeds[-count:]]}


def difference(case, own, peer):
    own, peer = parts(case, own), parts(case, peer)
    for name, theirs in peer.items():
        mine = own[name]
        if name == "contour":
            kinds = {"linear": "feed"}
            for at, (a, b) in enumerate(zip(mine, theirs)):
                if kinds.get(a[0], a[0]) != b[0] or not near(a[1], b[1]) or not near(a[2], b[2]):
                    return f"{name} {at + 1}: {a} here, {b} in rs274"
        for at, (a, b) in enumerate(zip(mine, theirs)):
            if name != "contour" and not near(a, b):
                return f"{name} {at + 1}: {a} here, {b} in rs274"
        if len(mine) != len(theirs):
            return f"{len(mine)} {name} here, {len(theirs)} in rs274"
    return ""


def compare(args, folder, seed):
    case = case_of(seed)
    peer, why = peer_moves(args, folder, f"p{seed}", peer_program(case))
    if peer is None:
        return "refused", why
    own, told = own_moves(args, folder, f"p{seed}", own_program(case))
    what = difference(case, own, peer)
    return "different" if what else "equal", what + (f" ({'; '.join(told)})" if what and told else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=300)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--counterpoint", default=os.path.join(rs274.ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--rs274", default="rs274")
    parser.add_argument("--show", type=int)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rs274.prepare(folder, MACHINE)
        if args.show is not None:
            case = case_of(args.show)
            for program, moves in ((own_program(case), own_moves), (peer_program(case), peer_moves)):
                print("\n".join(program))
                print(*moves(args, folder, "shown", program)[0] or [], sep="\n")
            return 0
        counts = {}
        for seed in range(args.first, args.first + args.seeds):
            verdict, what = compare(args, folder, seed)
            kind = case_of(seed)["kind"]
            counts[kind, verdict] = counts.get((kind, verdict), 0) + 1
            if verdict == "different":
                print(f"seed {seed}: {what}", flush=True)
        for (kind, verdict), count in sorted(counts.items()):
            print(f"{kind}: {count} {verdict}")
        return 1 if any(verdict == "different" for _, verdict in counts) else 0


if __name__ == "__main__":
    sys.exit(main())
