#!/usr/bin/env python3
"""Tests of tests/benchmark/compare. Usage: compare_test.py [TABLE]: with the program springnet_steps_table, it also
compares what that writes with itself."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

compare = pathlib.Path(__file__).resolve().parent / "compare"
table = None


def row(name, ratio, **more):
    return {"name": name, "ratio": ratio, "sweeps_per_step": 3.0, "krylov_iterations_per_step": 40.0, **more}


def document(*rows, **more):
    return {"format": "springnet steps table 1", "processor": "P", "rows": list(rows), **more}


class Compare(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def file(self, name, content):
        path = pathlib.Path(self.folder.name) / name
        path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
        return str(path)

    def run_compare(self, old, new, *arguments):
        files = [self.file("old.json", old), self.file("new.json", new)]
        return subprocess.run([sys.executable, str(compare), *files, *arguments], capture_output=True, text=True,
                              check=False)

    def test_faster_and_equal_rows_pass(self):
        done = self.run_compare(document(row("tube", 320.0), row("cube", 10.0)),
                                document(row("tube", 64.0, floor=78, sweeps_per_step=2.5), row("cube", 10.5)))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("| tube | 320 | 64 | 0.200 | 3 -> 2.5 | 40 | 78 reached |", done.stdout)
        self.assertIn("| cube | 10 | 10.5 | 1.050 | 3 | 40 |  |", done.stdout)
        self.assertEqual(done.stderr, "")

    def test_a_slower_row_fails_beyond_the_limit(self):
        old, new = document(row("tube", 100.0), row("cube", 10.0)), document(row("tube", 120.0), row("cube", 10.0))
        done = self.run_compare(old, new)
        self.assertEqual(done.returncode, 1)
        self.assertIn("tube (+20 %)", done.stderr)
        self.assertNotIn("cube", done.stderr)
        self.assertEqual(self.run_compare(old, new, "--limit", "25").returncode, 0)
        self.assertEqual(self.run_compare(new, old, "--limit", "0").returncode, 0)

    def test_a_row_that_fails_now_is_worse(self):
        failed = {"name": "tube", "failure": "diverges"}
        done = self.run_compare(document(row("tube", 100.0)), document(failed))
        self.assertEqual(done.returncode, 1)
        self.assertIn("failed: diverges", done.stdout)
        self.assertEqual(self.run_compare(document(failed), document(row("tube", 100.0))).returncode, 0)

    def test_rows_of_one_file_and_other_machines_are_named(self):
        done = self.run_compare(document(row("tube", 1.0), row("cube", 1.0)),
                                document(row("tube", 1.0), row("sheet", 1.0), processor="Q"))
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stdout, r"only in .*old.json: cube")
        self.assertRegex(done.stdout, r"only in .*new.json: sheet")
        self.assertIn("processor: P -> Q", done.stdout)

    def test_bad_input_is_told_by_file_and_place(self):
        good = document(row("tube", 1.0))
        for content, message in [
                ("{", "is not JSON"),
                ("[]", "is not of the format"),
                ({"rows": []}, "is not of the format"),
                ({"format": "springnet steps table 1"}, "'rows' must be a list"),
                (document({"ratio": 1.0}), "rows with a name"),
                (document(row("tube", 1.0), row("tube", 1.0)), "row 'tube' occurs twice"),
                (document(row("tube", "fast")), "'ratio' must be a number above 0, is \"fast\""),
                (document(row("tube", 0.0)), "'ratio' must be a number above 0, is 0.0"),
                (document(row("tube", float("nan"))), "'ratio' must be a number above 0, is NaN"),
                (document({"name": "tube"}), "'ratio' must be a number above 0, is null"),
                (document(row("cube", 1.0)), "no row in common")]:
            with self.subTest(message=message, content=content):
                done = self.run_compare(good, content)
                self.assertEqual(done.returncode, 2, done.stdout)
                self.assertIn("new.json", done.stderr)
                self.assertIn(message, done.stderr)
                self.assertNotIn("Traceback", done.stderr)

    def test_a_file_that_is_missing_or_not_text_is_told(self):
        new = self.file("new.json", document(row("tube", 1.0)))
        binary = pathlib.Path(self.folder.name) / "binary.json"
        binary.write_bytes(b"\xff\xfe\x00")
        for old, message in [("absent.json", "absent.json: No such file"), (str(binary), "is not JSON")]:
            done = subprocess.run([sys.executable, str(compare), old, new], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 2)
            self.assertIn(message, done.stderr)
            self.assertNotIn("Traceback", done.stderr)

    def test_arguments_are_checked(self):
        good = document(row("tube", 1.0))
        for limit in ["-1", "nan", "much"]:
            self.assertEqual(self.run_compare(good, good, "--limit", limit).returncode, 2)

    def test_what_the_program_writes_equals_itself(self):
        if table is None:
            self.skipTest("no program given")
        file = str(pathlib.Path(self.folder.name) / "table.json")
        subprocess.run([table, "--quick", "--only", "lattice-8", "--only", "cube*", "--json", file], check=True,
                       capture_output=True)
        done = subprocess.run([sys.executable, str(compare), file, file, "--limit", "0"], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ["lattice-8", "cube", "cube-cvode"]:
            self.assertRegex(done.stdout, rf"\| {name} \| .* \| 1.000 \|")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        table = sys.argv.pop(1)
    unittest.main()
