"""Tests of the functions of run.py that need neither git nor the binary."""
import os
import tempfile
import unittest

import run


def program(**fields):
    """A row of the list."""
    row = {"family": "fanuc", "machine": "fanuc-mill", "repository": "a/b", "files": ["p.nc"], "verdict": "clean"}
    row.update({"expected": frozenset(), "reason": "-", "line": 2}, **fields)
    return run.Program(**row)


class Functions(unittest.TestCase):
    def test_a_range_of_lines_is_split_from_the_path(self):
        self.assertEqual(run.split_range("a/b@c.txt@7-40"), ("a/b@c.txt", 7, 40))
        self.assertEqual(run.split_range("a.txt@7-"), ("a.txt", 7, None))
        self.assertEqual(run.split_range("a@b.nc"), ("a@b.nc", 1, None))

    def test_lines_keep_their_ends(self):
        self.assertEqual(run.cut(b"1\r\n2\n3", 2, None), b"2\n3")
        self.assertEqual(run.cut(b"1\r\n2\n3", 1, 1), b"1\r\n")

    def test_other_files_lie_below_with(self):
        with tempfile.TemporaryDirectory() as folder:
            main, others = run.lay_out(program(files=["x/p.nc@2-", "y/O7"]), folder, lambda path: b"1\n" + path.encode())
            self.assertEqual(os.path.relpath(main, folder), "p.nc")
            self.assertEqual([os.path.relpath(path, folder) for path in others], [os.path.join("with", "O7")])
            with open(main, "rb") as file:
                self.assertEqual(file.read(), b"x/p.nc")

    def test_outcome_has_the_numbers_of_errors_and_the_verdict(self):
        found = {"number": 2900320, "severity": 8, "file": "d/p.nc", "line": 4, "text": "no M77", "block": "M77"}
        warning = {**found, "number": 2900324, "severity": 4}
        summary = {"diagnostics": [warning, found], "verdict": None}
        self.assertEqual(run.outcome(summary), ("stopped", {"2900320"}, "p.nc:4: no M77 [M77]"))
        self.assertEqual(run.outcome({"diagnostics": [warning], "verdict": None}), ("succeeded", frozenset(), ""))
        limit = {"diagnostics": [], "verdict": {"kind": "LIMIT", "text": "too long"}}
        self.assertEqual(run.outcome(limit), ("stopped", {"LIMIT"}, "too long"))
        self.assertEqual(run.outcome("no end in 60 s"), ("not run", frozenset(), "no end in 60 s"))

    def test_an_outcome_differs_by_its_numbers_or_if_it_is_missing(self):
        self.assertFalse(run.differs(program(), "succeeded", frozenset()))
        self.assertTrue(run.differs(program(), "not run", frozenset()))
        self.assertTrue(run.differs(program(expected=frozenset({"1"})), "stopped", frozenset({"2"})))

    def test_the_table_adds_up(self):
        lines = run.table([program(), program(family="haas", verdict="alarm")], [("succeeded", 0, ""), ("stopped", 0, "")])
        self.assertEqual(lines[0].split()[:3], ["family", "programs", "clean"])
        self.assertEqual(lines[-1].split(), ["all", "2", "1", "1", "0", "0", "1", "1", "0"])

    def test_the_tables_are_those_of_the_documentation(self):
        with open(os.path.join(run.ROOT, "docs", "coverage", "programs.md"), encoding="utf-8") as file:
            text = file.read()
        for table in "\n".join(run.markdown(run.read_programs(os.path.join(run.HERE, "programs.tsv")))).split("\n\n"):
            self.assertIn(table, text)

    def test_the_list_is_valid(self):
        repositories = run.read_repositories(os.path.join(run.HERE, "repositories.tsv"))
        programs = run.read_programs(os.path.join(run.HERE, "programs.tsv"))
        self.assertEqual({p.repository for p in programs}, set(repositories))
        for p in programs:
            if p.verdict == "clean":
                self.assertIn(p.expected, [set()] + [{"2900070", "LIMIT"}] * ("for ever" in p.reason), p)
            elif p.verdict != "silent":
                self.assertTrue(p.expected, p)


if __name__ == "__main__":
    unittest.main()
