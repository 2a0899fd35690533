#!/usr/bin/env python3
"""Makes counterpoint/v1 from the contract: messages and stubs, both with their types (.pyi).

Also makes counterpoint/refusal_pb2.py, the messages for the details of refusals.

usage: generate.py [--out FOLDER]
"""

import argparse
import os
import pathlib
import sys

import grpc_tools
from grpc_tools import protoc

HERE = pathlib.Path(__file__).resolve().parent


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=pathlib.Path, default=HERE)
    out = parser.parse_args().out
    proto = HERE.parent.parent / "proto"
    files = sorted(str(file.relative_to(proto)) for file in proto.glob("counterpoint/v1/*.proto"))
    # The plug-ins of mypy-protobuf stand beside the interpreter, which need not be on the PATH.
    os.environ["PATH"] = os.pathsep.join([str(pathlib.Path(sys.executable).parent), os.environ.get("PATH", "")])
    # grpcio-tools has the messages of google.protobuf.
    known = pathlib.Path(grpc_tools.__file__).parent / "_proto"
    messages = [f"--python_out={out}", f"--mypy_out=quiet:{out}"]
    stubs = [f"--grpc_python_out={out}", f"--mypy_grpc_out=quiet:{out}"]
    code = protoc.main(["protoc", f"-I{proto}", *messages, *stubs, *files])
    code = code or protoc.main(["protoc", f"-I{HERE}", f"-I{known}", *messages, "counterpoint/refusal.proto"])
    if code == 0:
        (out / "counterpoint" / "v1" / "__init__.py").write_text('"""Messages and stubs of the contract, generated."""\n')
    return code


if __name__ == "__main__":
    sys.exit(main())
