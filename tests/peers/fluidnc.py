#!/usr/bin/env python3
"""Runs the fixtures of FluidNC by `counterpoint run` on the machine `linuxcnc-mill`, which has the nearest language.
Compares the printed lines with those that the fixtures expect. This repository holds no fixture.

usage: fluidnc.py REPOSITORY [--counterpoint BINARY]

REPOSITORY is a (bare) clone of github.com/bdring/FluidNC. Its folder `fixture_tests/fixtures` has lines to send (`->`)
and lines to receive (`<-`). Commands of the sender ($X, ??) are left out, unless they are inside an O code. A fixture
counts if it prints; KNOWN lists the fixtures that differ for a reason.
"""
import argparse
import json
import os
import re
import subprocess
import sys
import tempfile

from linuxcnc_tests import git
from rs274 import ROOT

KNOWN = {
    "current_tool_test.nc": "M61 is not emulated, and FluidNC starts with the tool numbers -1 and 0",
}


def fixtures(repository):
    """Name, lines of the program and printed lines of each fixture."""
    folder = "fixture_tests/fixtures/"
    for name in git(repository, "ls-tree", "-r", "--name-only", "HEAD", folder).decode().splitlines():
        text = git(repository, "show", f"HEAD:{name}").decode(errors="replace")
        sent = [line[3:] for line in text.splitlines() if line.startswith("-> ")]
        printed = re.findall(r"^<- \[MSG:INFO: PRINT,(.*)\]$", text, re.M)
        lines, inside = [], 0
        for line in sent:
            inside += len(re.findall(r"^o\d+ +(?:if|while|do|repeat)\b", line)) - len(re.findall(r"^o\d+ +end", line))
            if inside or not line.lstrip().startswith(("$", "?")):
                lines.append(line)
        if printed:
            yield name[len(folder):], lines, [line.strip() for line in printed]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("repository")
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    args = parser.parse_args()
    counts = {"equal": 0, "different": 0, "different for a reason": 0}
    with tempfile.TemporaryDirectory() as folder:
        for name, lines, printed in fixtures(args.repository):
            path = os.path.join(folder, "fixture.ngc")
            with open(path, "w", encoding="utf-8") as file:
                file.write("\n".join([*lines, "M2"]) + "\n")
            subprocess.run([args.counterpoint, "run", "--quiet", "--machine", "linuxcnc-mill", "--out", folder, "--write",
                            "events", path], capture_output=True, check=False)
            with open(os.path.join(folder, "events.jsonl"), encoding="utf-8") as file:
                events = [json.loads(line) for line in file]
            # FluidNC prints a comma of the text as a blank.
            own = [event["text"] for event in events if event["kind"] == "message"]
            plain = lambda texts: [" ".join(text.replace(",", " ").split()) for text in texts]
            same = plain(own) == plain(printed)
            reason = "" if same else KNOWN.get(name, "")
            counts["equal" if same else "different for a reason" if reason else "different"] += 1
            print(f"{name}: {f'{len(own)} lines' if same else reason or f'{own} here, {printed} expected'}")
    print(", ".join(f"{count} {kind}" for kind, count in counts.items()))
    return 1 if counts["different"] else 0


if __name__ == "__main__":
    sys.exit(main())
