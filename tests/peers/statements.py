#!/usr/bin/env python3
"""Instructions that each control's statements cost, counted by valgrind, and rs274 (LinuxCNC) on the same loops.

usage: statements.py [--counterpoint BINARY] [--passes N] [--only LOOP] [--peer]

Loops: `trig` (two functions, a product and a sum), `calls` (a subprogram with one statement), `circles` (a full circle by its
centre), `words` (the same in the plainest words that the control has: `I` and `J` as they stand; Heidenhain straight lines).
`counterpoint run` runs each with N and with 2 N passes; the difference over N is what one pass costs, start and end
left out. The count repeats to within a few per mille whatever else the machine does. With --peer, CPU seconds of rs274
and of the whole `counterpoint run` for 200,000 passes (100,000 of `calls`), run in turn: medians of 12 runs, and the median of the
12 ratios, since a machine that others share changes its pace within minutes.
"""
import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile

from compare import measure

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
OKUMA = 'extends = "fanuc-mill"\n\n[ce]\nname = "mill-okuma"\npreprocessor = "okuma"\n'

FANUC = {
    "trig": "O1\n#1=0\nWHILE[#1LT{n}]DO1\n#2=SIN[#1]*10.+COS[#1]\n#1=#1+1\nEND1\nM30\n",
    "calls": "O1\n#1=0\nWHILE[#1LT{n}]DO1\nM98P2\n#1=#1+1\nEND1\nM30\nO2\n#2=#1\nM99\n",
    "circles": "O1\nG17 G90 G21 G94\n#1=0\nG0 X0. Y0.\nF1000.\nWHILE[#1LT{n}]DO1\nG2 X10. Y0. I5. J0.\nG2 X0. Y0. I-5. J0.\n#1=#1+1\nEND1\nM30\n",
}
FANUC["words"] = FANUC["circles"]
SIEMENS = {
    "trig": "R1=0\nWHILE R1<{n}\nR2=SIN(R1)*10+COS(R1)\nR1=R1+1\nENDWHILE\nM30\n",
    "calls": "R1=0\nWHILE R1<{n}\nSUB\nR1=R1+1\nENDWHILE\nM30\n",
    "circles": "G17 G90 G71 G94\nR1=0\nG0 X0 Y0\nF1000\nWHILE R1<{n}\nG2 X10 Y0 I=5 J=0\nG2 X0 Y0 I=AC(5) J=0\nR1=R1+1\nENDWHILE\nM30\n",
    "words": "G17 G90 G71 G94\nR1=0\nG0 X0 Y0\nF1000\nWHILE R1<{n}\nG2 X10 Y0 I5 J0\nG2 X0 Y0 I-5 J0\nR1=R1+1\nENDWHILE\nM30\n",
}
HEIDENHAIN = {
    "trig": "BEGIN PGM T MM\nQ1 = 0\nLBL 1\nQ2 = SIN Q1 * 10 + COS Q1\nQ1 = Q1 + 1\nFN 12: IF +Q1 LT +{n} GOTO LBL 1\nEND PGM T MM\n",
    "calls": "BEGIN PGM T MM\nQ1 = 0\nLBL 1\nCALL LBL 2\nQ1 = Q1 + 1\nFN 12: IF +Q1 LT +{n} GOTO LBL 1\nSTOP M30\nLBL 2\nQ2 = Q1\nLBL 0\nEND PGM T MM\n",
    "circles": "BEGIN PGM T MM\nQ1 = 0\nTOOL CALL 1 Z S1000\nL X+0 Y+0 R0 FMAX\nLBL 1\nCC X+5 Y+0\nC X+10 Y+0 DR- F1000\nC X+0 Y+0 DR-\nQ1 = Q1 + 1\nFN 12: IF +Q1 LT +{n} GOTO LBL 1\nEND PGM T MM\n",
    "words": "BEGIN PGM T MM\nQ1 = 0\nTOOL CALL 1 Z S1000\nL X+0 Y+0 R0 FMAX\nLBL 1\nL X+10 Y+0 F1000\nL X+0 Y+0\nQ1 = Q1 + 1\nFN 12: IF +Q1 LT +{n} GOTO LBL 1\nEND PGM T MM\n",
}
OSP = {
    "trig": "O1\nV1=0\nNLOOP V2=SIN[V1]*10+COS[V1]\nV1=V1+1\nIF[V1 LT {n}]NLOOP\nM30\n",
    "calls": "O1\nV1=0\nNLOOP CALL O2\nV1=V1+1\nIF[V1 LT {n}]NLOOP\nM30\nO2\nV2=V1\nRTS\n",
    "circles": "O1\nG17 G90 G21 G94\nV1=0\nG0 X0 Y0\nNLOOP G2 X10 Y0 I5 J0 F1000\nG2 X0 Y0 I=-5 J0\nV1=V1+1\nIF[V1 LT {n}]NLOOP\nM30\n",
    "words": "O1\nG17 G90 G21 G94\nV1=0\nG0 X0 Y0\nNLOOP G2 X10 Y0 I5 J0 F1000\nG2 X0 Y0 I-5 J0\nV1=V1+1\nIF[V1 LT {n}]NLOOP\nM30\n",
}
PEER = {
    "trig": "#1=0\no1 while [#1 LT {n}]\n#2=[SIN[#1]*10+COS[#1]]\n#1=[#1+1]\no1 endwhile\nM2\n",
    "calls": "o2 sub\n#2=#1\no2 endsub\n#1=0\no1 while [#1 LT {n}]\no2 call\n#1=[#1+1]\no1 endwhile\nM2\n",
    "circles": "G17 G90 G21 G94 F1000\n#1=0\nG0 X0 Y0\no1 while [#1 LT {n}]\nG2 X10 Y0 I5 J0\nG2 X0 Y0 I-5 J0\n#1=[#1+1]\no1 endwhile\nM2\n",
}
CONTROLS = {
    "fanuc": ("fanuc-mill", "p.nc", FANUC),
    "siemens": ("siemens-mill", "p.mpf", SIEMENS),
    "heidenhain": ("heidenhain-mill", "p.h", HEIDENHAIN),
    "okuma": ("mill-okuma", "p.min", OSP),
}


def write(folder, control, loop, passes):
    """The command line's words for a program: machine and files."""
    machine, name, loops = CONTROLS[control]
    path = os.path.join(folder, f"{passes}{name}")
    with open(path, "w", encoding="ascii") as file:
        file.write(loops[loop].format(n=passes))
    if control == "okuma":
        machine = os.path.join(folder, machine)
        os.makedirs(machine, exist_ok=True)
        with open(os.path.join(machine, "machine.toml"), "w", encoding="ascii") as file:
            file.write(OKUMA)
    words = ["--machine", machine, path]
    if control == "siemens" and loop == "calls":
        sub = os.path.join(folder, "sub.spf")
        with open(sub, "w", encoding="ascii") as file:
            file.write("R2=R1\nRET\n")
        words += ["--with", sub]
    return words


def count(binary, words, log):
    """Instructions of one run inside the kernel."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", f"--log-file={log}"]
    command += ["--toggle-collect=*Kernel*live*", binary, "run", "--quiet", *words]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    with open(log, encoding="utf-8") as file:
        found = re.search(r"Collected :\s+(\d+)", file.read())
    if done.returncode != 0 or not found:
        sys.exit(f"{' '.join(command)} failed with status {done.returncode}: {done.stderr.decode()}")
    return int(found.group(1))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--passes", type=int, default=5_000)
    parser.add_argument("--only", choices=list(FANUC))
    parser.add_argument("--peer", action="store_true")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for loop in [args.only] if args.only else FANUC:
            base = None
            for control in CONTROLS:
                few, many = (
                    count(args.counterpoint, write(folder, control, loop, args.passes * times), os.path.join(folder, "log"))
                    for times in (1, 2)
                )
                each = (many - few) / args.passes
                base = base or each
                print(f"{loop:8} {control:11} {each:9.0f} instructions a pass, {each / base:5.2f} of fanuc", flush=True)
            if args.peer and loop in PEER:
                path = os.path.join(folder, "peer.ngc")
                # A million blocks in a row that take no time are an endless loop for this project.
                passes = 100_000 if loop == "calls" else 200_000
                with open(path, "w", encoding="ascii") as file:
                    file.write(PEER[loop].format(n=passes))
                own = [args.counterpoint, "run", "--quiet", "--max-time", "1000000000", *write(folder, "fanuc", loop, passes)]
                pairs = [(measure(["rs274", "-g", path])[0], measure(own)[0]) for _ in range(12)]
                theirs, ours = (statistics.median(times) for times in zip(*pairs))
                ratio = statistics.median(peer / here for peer, here in pairs)
                print(f"{loop:8} rs274 {theirs:.3f} CPU s, here {ours:.3f} CPU s, ratio {ratio:.1f}", flush=True)


if __name__ == "__main__":
    main()
