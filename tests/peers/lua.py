#!/usr/bin/env python3
"""Compares the macro language with Lua 5.4 on the same loops, in one run.

    python3 tests/peers/lua.py

Needs lua5.4 and cargo. Prints one row per loop: milliseconds here, milliseconds in Lua, and how many times as fast. The
two sides take turns, and each gives the best time of single runs, which other work on the machine disturbs least.
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
    # A function that may print.
    "call": """local function added(a,b) if a<0 then print('NEGATIVE') end return a+b end
        local s=0.0 for i=1,100000 do s=added(s,i) end""",
    "matrix": """local a,b={},{} for i=1,100 do a[i],b[i]={},{} for j=1,100 do a[i][j],b[i][j]=0.0,0.0 end end
        for k=1,10 do for i=1,100 do for j=1,100 do a[i][j]=a[i][j]+i b[j][i]=a[i][j] end end end""",
    "locals": "local l1,l2=0.0,1.0 for l3=1.0,100000.0 do l1=l1+l2*l3 end",
    # Variables of every macro are those of Lua's environment.
    "globals": "G01=0.0 G02=1.0 for i=1.0,100000.0 do G01=G01+G02*i end",
    # Variables of an object are the locals of a file that its functions share.
    "object": """local total,factor=0.0,2.0
        local function work() for i=1.0,100000.0 do total=total+factor*i end end work()""",
    "object_text": """local work='MILL'
        local function count() local n=0.0 for i=1,100000 do if work=='MILL' then n=n+1 end end end count()""",
    "object_array": """local wear={} for i=1,1000 do wear[i]=0.0 end
        local function work() for j=1,100 do for i=1,1000 do wear[i]=wear[i]+i end end end work()""",
    "object_matrix": """local life={} for i=1,100 do life[i]={} for j=1,100 do life[i][j]=0.0 end end
        local function work()
            for k=1,10 do for i=1,100 do for j=1,100 do life[i][j]=life[i][j]+i end end end
        end work()""",
    "record_made": "local s=0.0 for i=1.0,100000.0 do local r={i,'MILL',true} s=s+r[1] end",
    "record_fields": """local r,n={1.0,'MILL',3.0,4.0},0.0
        for i=1.0,100000.0 do r[3]=r[1]+i r[4]=r[3]-r[1] if r[2]=='MILL' then n=n+1 end end""",
    "table": """local t={} for i=1,50 do t[i]={string.format('TOOL%02d',i),i+0.0,0.0} end
        for j=1,1000 do
            for i=1,50 do if t[i][1]=='TOOL50' then t[i][3]=t[i][3]+t[i][2] local name=t[i][1] end end
        end""",
    "text": "for j=1,1000 do local t='' for i=1,50 do t=t..'G1 X'..' ' end end",
    "format": "for i=1.0,10000.0 do local t=string.format('N%05d X%9.3f %s',i,i,'F100') end",
    "untyped": """local function pick(name,a,b) local r if name=='MILL' then r=a else r=b end return r end
        local s for i=1.0,100000.0 do s=pick('MILL',i,'NONE') end""",
    # Arguments of a macro.
    "arguments": """local function macro(p1,p2,p3)
            local s=0.0
            for i=1.0,100000.0 do p1=p1+p2*i if p3==true then s=s+1 end end
            return p1,p2,p3
        end macro(0.0,2.0,true)""",
    "cases": """local n=0.0 for i=1.0,100000.0 do
            local k=math.fmod(i,7)
            if k==0 then n=n+1 elseif k==1 or k==2 then n=n+2 elseif k>=3 and k<=5 then n=n+3 else n=n+4 end
        end""",
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
    subprocess.run([*command, "--sample-size", "50", "--measurement-time", "0.05", "--warm-up-time", "0.02"], cwd=ROOT, check=True,
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
