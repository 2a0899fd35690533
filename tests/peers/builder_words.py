#!/usr/bin/env python3
"""Runs words of machine builders, each in a program of its own, on the shipped machine with the words of that builder,
and prints the meaning that each word has there.

usage: builder_words.py [--counterpoint BINARY] [--write] [FILTER ...]

builder-words.tsv has builder, machine, word, meaning on the builder's machine, and the outcome here:

* codes (CODE_SPINDLE02_CLW): the machine has a row for the word. CODE_IGNORE and CODE_FUNCTION take no part in the
  motion, so the machine's README.md must name the word, otherwise the outcome begins with `unnamed`;
* `refused` with the number of the first error;
* `warned` with codes and the number of the first warning: accepted, and reported;
* `accepted`: no report and no code, as for axis words and statements.

A word that waits for another channel is run in all channels. The exit code is 1 if an outcome differs from the list;
`--write` writes the outcomes into it. FILTER is a part of builder or machine.
"""
import argparse
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import tempfile

from rs274 import HERE, ROOT

LIST = os.path.join(HERE, "builder-words.tsv")

# Ending of the programs, blocks before the word, and the end.
SHAPES = {
    "siemens": (".mpf", ["G90 G94 G0 X100 Z100 F500"], "M30"),
    "okuma": (".min", ["G90 G0 X100 Z100"], "M02"),
    "": (".nc", ["G0 X100. Z100."], "M30"),
}


def shape(machine):
    return next(shape for start, shape in SHAPES.items() if machine.startswith(start))


def run(args, folder, machine, programs):
    """Severity and number of each report of a run."""
    ending, before, end = shape(machine)
    paths = []
    for at, words in enumerate(programs):
        path = os.path.join(folder, f"w{at + 1}{ending}")
        with open(path, "w", encoding="ascii") as file:
            file.write("\n".join([*before, *words, end]) + "\n")
        paths.append(path)
    done = subprocess.run([args.counterpoint, "run", "--json", "--max-time", "10000", "--machine", machine, *paths],
                          capture_output=True, text=True, check=False)
    if not done.stdout:
        return [(99, 0, done.stderr[-200:])]
    found = json.loads(done.stdout).get("diagnostics", [])
    return [(one["severity"], one["number"], one.get("text", "")) for one in found]


def codes(args, known, machine, word):
    """Identifiers of the codes that the machine has for the G and M words of a block."""
    out = []
    for letter, number in re.findall(r"(?<![A-Z=\[.])([GM])(\d+(?:\.\d+)?)(?![\d=])", word):
        key = (machine, letter + number)
        if key not in known:
            done = subprocess.run([args.counterpoint, "explain", "--json", "--machine", machine, letter + number],
                                  capture_output=True, text=True, check=False)
            words = json.loads(done.stdout).get("words", []) if done.stdout else []
            known[key] = [code["id"] for one in words for code in one.get("codes", [])][:1]
        out += known[key]
    return out


def is_named(machine, word, named):
    """Whether the README of the machine, or of a machine that it extends, names all G and M words of a block."""
    if machine not in named:
        text, folder = "", machine
        while folder:
            for name in ("README.md", "machine.toml"):
                path = os.path.join(ROOT, "machines", folder, name)
                if os.path.exists(path):
                    with open(path, encoding="utf-8") as file:
                        content = file.read()
                    text += content if name == "README.md" else ""
            found = re.search(r'^extends = "([\w-]+)"', content, re.M)
            folder = found.group(1) if found else ""
        spans = [(a, int(b), int(c)) for a, b, c in re.findall(r"\b([GM])(\d+) (?:to|-) \1?(\d+)", text)]
        named[machine] = (set(re.findall(r"\b[GM]\d+(?:\.\d+)?", text)), spans)
    words, spans = named[machine]
    return all(one in words or any(one[0] == a and b <= float(one[1:]) <= c for a, b, c in spans)
               for one in re.findall(r"\b[GM]\d+(?:\.\d+)?", word))


def outcome(args, known, named, folder, machine, word):
    found = run(args, folder, machine, [[word]])
    if any(number == 2900071 for _, number, _ in found):
        with open(os.path.join(ROOT, "machines", machine, "machine.toml"), encoding="utf-8") as file:
            channels = max(2, file.read().count("[[channels]]"))
        found = run(args, folder, machine, [[word]] * channels)
    errors = [number for severity, number, _ in found if severity >= 8]
    if errors:
        return f"refused {errors[0]}"
    names = codes(args, known, machine, word)
    quiet = names and all(name in ("CODE_IGNORE", "CODE_FUNCTION") for name in names)
    text = ("unnamed " if quiet and not is_named(machine, word, named) else "") + (" ".join(names) or "accepted")
    warned = [number for severity, number, _ in found if 4 <= severity < 8]
    return f"warned {warned[0]} {text}" if warned else text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counterpoint", default=os.path.join(ROOT, "target", "release", "counterpoint"))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("filter", nargs="*")
    args = parser.parse_args()
    with open(LIST, encoding="utf-8") as file:
        head, *rows = [line.rstrip("\n").split("\t") for line in file]
    chosen = [row for row in rows if all(any(word in field for field in row[:2]) for word in args.filter)]
    known, named, counts, different = {}, {}, {}, 0

    def one(row):
        with tempfile.TemporaryDirectory() as folder:
            return outcome(args, known, named, folder, row[1], row[2])

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for row, found in zip(chosen, pool.map(one, chosen)):
            kind = found.split()[0] if found.split()[0] in ("refused", "warned", "unnamed", "accepted") else "codes"
            counts[kind] = counts.get(kind, 0) + 1
            if row[4] != found:
                different += 1
                print(f"{row[1]}: {row[2]} ({row[3]}): {found}" + (f" instead of {row[4]}" if row[4] else ""), flush=True)
            row[4] = found
    if args.write:
        with open(LIST, "w", encoding="utf-8") as file:
            file.write("".join("\t".join(row) + "\n" for row in [head, *rows]))
    print(f"{len(chosen)} words: " + ", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())))
    print(f"{different} of {len(chosen)} outcomes differ from the list")
    return 1 if different and not args.write else 0


if __name__ == "__main__":
    sys.exit(main())
