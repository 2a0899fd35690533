#!/usr/bin/env python3
"""CPU seconds of rs274 (LinuxCNC, Debian package linuxcnc-uspace) and of `counterpoint run` on the same program.

usage: compare.py [--counterpoint BINARY] [--runs N] [--programs FOLDER] [--blocks N]

They run in turn, N times each; the medians of user + system time count. `counterpoint run` goes the whole way:
embedded server, gRPC, fingerprint, summary and timeline built; without `--out` nobody asks for a listing, a log or a
toolpath. It runs with the times of the machine (look-ahead)
and with `--time simple`, since rs274 does not plan speeds. FOLDER holds mill.ngc and mill.nc;
without it they are made by mill.py.
"""
import argparse
import os
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))


def measure(command):
    """CPU seconds and peak memory (KiB) of a command that must succeed."""
    pid = os.fork()
    if pid == 0:
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        os.execvp(command[0], command)
    _, status, usage = os.wait4(pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(command)} failed with status {status}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--runs", type=int, default=7)
    parser.add_argument("--programs")
    parser.add_argument("--blocks", type=int, default=200_000)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        programs = args.programs or folder
        if not args.programs:
            subprocess.run([sys.executable, os.path.join(HERE, "mill.py"), folder, str(args.blocks)], check=True)
        peer = ["rs274", "-g", os.path.join(programs, "mill.ngc")]
        program = os.path.join(programs, "mill.nc")
        own = [args.counterpoint, "run", "--quiet", "--machine", "fanuc-mill", program]
        commands = {"rs274": peer, "look-ahead": own, "simple": own + ["--time", "simple"]}
        size = os.path.getsize(program) / 1048576
        rows = {name: [] for name in commands}
        for _ in range(args.runs):
            for name, command in commands.items():
                rows[name].append(measure(command))
    cpu = {name: statistics.median(r[0] for r in runs) for name, runs in rows.items()}
    peak = {name: max(r[1] for r in runs) / 1024 for name, runs in rows.items()}
    for name in rows:
        spread = sorted(r[0] for r in rows[name])
        ratio = f"; rs274 takes {cpu['rs274'] / cpu[name]:.1f} times as long" if name != "rs274" else ""
        print(f"{name:10} {cpu[name]:7.3f} CPU s (from {spread[0]:.3f} to {spread[-1]:.3f}), peak {peak[name]:.1f} MiB{ratio}")
    print(f"the file has {size:.1f} MiB")


if __name__ == "__main__":
    main()
