#!/usr/bin/env python3
"""Writes the same milling program for both interpreters: mill.ngc (rs274) and mill.nc (Counterpoint).

usage: mill.py OUTDIR [BLOCKS]

Four straight moves and one quarter circle in turn, words kept modal where they can be. No randomness, no clock.
"""
import math
import os
import sys


def number(value):
    text = f"{value:.4f}".rstrip("0")
    return "0." if text == "-0." else text


def blocks(count):
    x = y = 0.0
    for k in range(count):
        t, m = k * 0.0013, k % 5
        if m == 4:
            radius = 1.5 + (k % 9) * 0.25
            clockwise = (k // 5) % 2 == 0
            i, j = (radius, 0.0) if clockwise else (0.0, radius)
            x, y = round(x + radius, 4), round(y + radius, 4)
            yield f"{'G2' if clockwise else 'G3'} X{number(x)} Y{number(y)} I{number(i)} J{number(j)}"
            continue
        x = round(60 + 35 * math.cos(t) + m * 0.11, 4)
        if m != 2:
            y = round(55 + 45 * math.sin(1.7 * t) + m * 0.07, 4)
        if m == 0:
            yield f"G1 X{number(x)} Y{number(y)} Z{number(-1 - (k % 800) * 0.002)} F{600 + k % 150}."
        elif m == 1:
            yield f"X{number(x)} Y{number(y)}"
        elif m == 2:
            yield f"X{number(x)}"
        else:
            yield f"G1 X{number(x)} Y{number(y)}"


def main():
    folder, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 200_000
    os.makedirs(folder, exist_ok=True)
    head = ["G17 G21 G90 G94 G40 G80", "G0 X0. Y0. Z5.", "S3000 M3", "G1 Z-1. F500."]
    tail = ["G0 Z5.", "M5", "M30"]
    body = list(blocks(count))
    for name, lines in (("mill.ngc", head + body + tail), ("mill.nc", ["%", "O1000"] + head + body + tail + ["%"])):
        with open(os.path.join(folder, name), "w", newline="\n") as out:
            out.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
