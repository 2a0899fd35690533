"""Runs the Python code of README.md in order, against the server at COUNTERPOINT_TEST_SERVER."""

import os
import pathlib
import re
import shutil
import tempfile
import unittest
from typing import Any, Dict
from unittest import mock

README = pathlib.Path(__file__).resolve().parents[1] / "README.md"
EXAMPLES = README.parents[2] / "examples" / "two-turret"


class Readme(unittest.TestCase):
    def test_the_code_runs(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)
        for name in ["upper.nc", "lower.nc"]:
            shutil.copy(EXAMPLES / name, name)
        pathlib.Path("part.nc").write_bytes(b"O1\nG90 G94 F100\nM98 P2\nM30\n")
        pathlib.Path("subprograms").mkdir()
        pathlib.Path("subprograms/O0002.nc").write_bytes(b"O2\nG1 X5.\nM99\n")
        server = f"http://{os.environ['COUNTERPOINT_TEST_SERVER']}"
        blocks = re.findall(r"^```python\n(.*?)^```$", README.read_text(), re.MULTILINE | re.DOTALL)
        self.assertEqual(len(blocks), 6)
        space: Dict[str, Any] = {}
        with mock.patch.dict(os.environ, {"COUNTERPOINT_SERVER": server}), mock.patch("builtins.print") as shown:
            for block in blocks:
                exec(block.replace("http://127.0.0.1:7878", server), space)
        space["client"].close()
        lines = [" ".join(map(str, call.args)) for call in shown.call_args_list]
        self.assertTrue(any(line.startswith("SUCCEEDED 240.") for line in lines), lines)
        self.assertTrue(any(line.startswith("Set-up: Feed, per cent, Face off by, mm") for line in lines), lines)
        # The job may have ended before the cancel.
        self.assertTrue({"CANCELLED True", "SUCCEEDED True"}.intersection(lines), lines)
        self.assertTrue(any(line.startswith("no machine 'fanuc-mil'") for line in lines), lines)
        self.assertTrue(any(line.startswith("INVALID_REQUEST StatusCode.INVALID_ARGUMENT") for line in lines), lines)
        for name in ["timeline.svg", "toolpath.svg"]:
            self.assertTrue(pathlib.Path(name).read_text().startswith("<svg"))


if __name__ == "__main__":
    unittest.main()
