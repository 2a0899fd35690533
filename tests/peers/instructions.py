#!/usr/bin/env python3
"""Instructions that a kernel spends on a block, its results included, counted by valgrind (Debian package valgrind).

usage: instructions.py [--counterpoint BINARY ...] [--blocks N]

`counterpoint run` runs the same program with N and with 2 N blocks, counted inside the kernel's life only; the
difference over N is what one block costs, start and end left out. The count repeats to within a few per mille
whatever else the machine does, so two binaries can be compared: give several. Programs: the mill of mill.py, and one
path of a lathe.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))


def lathe(path, blocks):
    """Turning passes: a rapid move and two cuts in turn."""
    with open(path, "w", encoding="ascii") as file:
        file.write("O1\nG18 G21 G97 G98 G40\nS1000 M3\nF200.\n")
        for k in range(blocks):
            x, z = 40 - k % 20 * 0.2, k % 50 * 0.5
            file.write(f"G1 X{x:.1f} Z-{z:.1f}\n" if k % 3 else f"G0 X{x + 5:.1f} Z-{z:.1f}\n")
        file.write("M30\n")


def mill(path, blocks):
    """The program of the comparison with rs274."""
    folder = os.path.dirname(path)
    subprocess.run([sys.executable, os.path.join(HERE, "mill.py"), folder, str(blocks)], check=True)
    os.replace(os.path.join(folder, "mill.nc"), path)


def count(binary, machine, program, log):
    """Instructions of one run."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", f"--log-file={log}"]
    command += ["--toggle-collect=*Kernel*live*"]
    command += [binary, "run", "--quiet", "--time", "simple", "--machine", machine, program]
    done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    with open(log, encoding="utf-8") as file:
        found = re.search(r"Collected :\s+(\d+)", file.read())
    if done.returncode != 0 or not found:
        sys.exit(f"{' '.join(command)} failed with status {done.returncode}: {done.stderr.decode()}")
    instructions = int(found.group(1).replace(",", ""))
    if instructions == 0:
        sys.exit(f"{binary} has no symbol of the kernel's life, so nothing was counted: give a binary that is not stripped")
    return instructions


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    own = os.path.join(ROOT, "target", "release", "counterpoint")
    parser.add_argument("--counterpoint", nargs="+", default=[own])
    parser.add_argument("--blocks", type=int, default=20_000)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for name, machine, make in [("mill", "fanuc-mill", mill), ("lathe", "fanuc-2path-lathe", lathe)]:
            programs = []
            for times in (1, 2):
                programs.append(os.path.join(folder, f"{name}{times}.nc"))
                make(programs[-1], args.blocks * times)
            for binary in args.counterpoint:
                few, many = (count(binary, machine, p, os.path.join(folder, "log")) for p in programs)
                print(f"{name:6} {(many - few) / args.blocks:8.1f} instructions a block  {binary}")


if __name__ == "__main__":
    main()
