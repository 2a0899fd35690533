#!/usr/bin/env python3
"""Makes counterpoint/v1 from the contract: messages, their types (.pyi) and stubs.

usage: generate.py [--out FOLDER]
"""

import argparse
import pathlib
import sys

from grpc_tools import protoc

HERE = pathlib.Path(__file__).resolve().parent


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, default=HERE)
    out = parser.parse_args().out
    proto = HERE.parent.parent / "proto"
    files = sorted(str(file.relative_to(proto)) for file in proto.glob("counterpoint/v1/*.proto"))
    options = [f"--python_out={out}", f"--pyi_out={out}", f"--grpc_python_out={out}"]
    code = protoc.main(["protoc", f"-I{proto}", *options, *files])
    if code == 0:
        (out / "counterpoint" / "v1" / "__init__.py").write_text('"""Messages and stubs of the contract, generated."""\n')
    return code


if __name__ == "__main__":
    sys.exit(main())
