#!/usr/bin/env python3
"""Writes seeds for the fuzz targets: the macros of the spec pages and tests, their formats and their expressions.

    python3 kernel/lang/fuzz/seeds.py <folder>
"""

import hashlib
import pathlib
import re
import sys

LANG = pathlib.Path(__file__).resolve().parents[1]
ROOT = LANG.parents[1]


def texts() -> list[str]:
    pages = [*sorted((ROOT / "tests" / "spec" / "lang").glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
    blocks = [block for page in pages for block in re.findall(r"```macro[^\n]*\n(.*?)```", page.read_text(), re.S)]
    sources = [*sorted((LANG / "tests").glob("*.rs")), *sorted((LANG / "benches").glob("*.rs")),
               *sorted((LANG / "src").rglob("*.rs"))]
    strings = [text for source in sources for text in re.findall(r'"((?:[^"\\]|\\.)*)"', source.read_text())]
    macros = [text.replace("\\n", "\n").replace("\\\\", "\\") for text in strings if "=" in text or "/" in text]
    return blocks + macros


def main() -> None:
    folder = pathlib.Path(sys.argv[1])
    macros = texts()
    literals = sorted({literal for text in macros for literal in re.findall(r"'([^'\n]*)'", text)})
    formats = [f"{text}\n{value}" for text in literals if "!(" in text for value in ("12.5", "X-1.25 Y3")]
    patterns = [f"{text}\n<\\1>\nN120 X1.5 Y22.75 Z-3 aab" for text in literals if re.search(r"[\\\[*^.$]", text)]
    seeds = {"lex": macros, "compile": ["\x00" + text for text in macros], "layout": macros, "run": macros,
             "formats": formats, "patterns": patterns}
    for target, lines in seeds.items():
        (folder / target).mkdir(parents=True, exist_ok=True)
        for text in lines:
            data = text.encode()
            (folder / target / hashlib.sha256(data).hexdigest()[:16]).write_bytes(data)


if __name__ == "__main__":
    main()
