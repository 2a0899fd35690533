#!/usr/bin/env python3
"""Compares the macro language with Lua 5.4 on the same loops, in one run.

    python3 tests/peers/lua.py

Needs lua5.4 and cargo. Prints one row per loop: milliseconds here, milliseconds in Lua, and how many times as fast. The
two sides take turns, and each gives its best time, which other work on the machine disturbs least.
"""

import json
import os
import pathlib
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[2]

ROUNDS = 3

LOOPS = {
    "arithmetic": "local s=0.0 for i=1.0,100000.0 do s=s+i*2-s/3 end",
    "branches": "local n,i=0.0,0.0 while i<100000 do i=i+1 if i%3==0 and i>5 then n=n+1 end end",
    "array": "local a={} for i=1,1000 do a[i]=0.0 end for j=1,100 do for i=1,1000 do a[i]=a[i]+i end end",
    "sequence": "for j=1,100 do local q={} for i=1,1000 do q[#q+1]=i+0.0 end end",
    "edit": "for i=1,10000 do local t=string.gsub('N120 X1.5 Y22.75 Z-3','[XYZ]([-0-9.]*)','<%1>') end",
    "function": "local function added(a,b) return a+b end local s=0.0 for i=1,100000 do s=added(s,i) end",
}

TIMER = """
local body = load([[%s]])
for i=1,20 do body() end
local best = math.huge
for i=1,40 do local t=os.clock() body() best=math.min(best,os.clock()-t) end
print(best*1000)
"""


def lua(body: str) -> float:
    run = subprocess.run(["lua5.4", "-"], input=TIMER % body, capture_output=True, text=True, check=True)
    return float(run.stdout)


def here(target: pathlib.Path) -> dict[str, float]:
    command = ["cargo", "bench", "-q", "-p", "counterpoint-lang", "--bench", "macros", "--", "--noplot"]
    subprocess.run([*command, "--measurement-time", "1", "--warm-up-time", "0.5"], cwd=ROOT, check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    best = {}
    for name in LOOPS:
        sample = json.loads((target / "criterion" / name / "new" / "sample.json").read_text())
        best[name] = min(time / count for time, count in zip(sample["times"], sample["iters"])) / 1e6
    return best


def main() -> None:
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    ours, theirs = [], []
    for _ in range(ROUNDS):
        ours.append(here(target))
        theirs.append({name: lua(body) for name, body in LOOPS.items()})
    print("| loop | here ms | lua 5.4 ms | times as fast |\n|---|---|---|---|")
    for name in LOOPS:
        a, b = (min(side[name] for side in sides) for sides in (ours, theirs))
        print(f"| {name} | {a:.3f} | {b:.3f} | {b / a:.2f} |")


if __name__ == "__main__":
    main()
