#!/usr/bin/env python3
"""Tests that .ci/run fails if a test was skipped, with a ctest that only prints.

    ci_run_test.py"""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

RUN = pathlib.Path(__file__).resolve().parents[2] / ".ci/run"
FUNCTION = re.search(r"^run_tests\(\) \{\n.*?^\}\n", RUN.read_text(), re.S | re.M).group()
SCRIPT = "1/2 Test #1: slurm.StudyAsAJobArray ...***Skipped 0.01 sec\n"
PROGRAM = "[  SKIPPED ] Scan.IsRead\n"


class CiRun(unittest.TestCase):
    def run_tests(self, printed, last="", data=True, code=0):
        with tempfile.TemporaryDirectory() as folder:
            top = pathlib.Path(folder) / "kerf"
            (top / "build/release/Testing/Temporary").mkdir(parents=True)
            (top / "build/release/Testing/Temporary/LastTest.log").write_text(last)
            if data:
                (top.parent / "shared/data").mkdir(parents=True)
            (top / "printed").write_text(printed)
            (top / "ctest").write_text(f"#!/bin/sh\ncat printed\nexit {code}\n")
            (top / "ctest").chmod(0o755)
            return subprocess.run(["bash", "-c", f"set -euo pipefail\nleft_out=none\n{FUNCTION}run_tests quick\n"], cwd=top, capture_output=True,
                                  text=True, env={**os.environ, "PATH": f"{top}:{os.environ['PATH']}"}).returncode

    def test_a_skipped_test_fails_whichever_of_the_logs_names_it(self):
        self.assertEqual(self.run_tests("100% tests passed\n"), 0)
        self.assertEqual(self.run_tests(SCRIPT), 1)
        self.assertEqual(self.run_tests("", PROGRAM), 1)
        self.assertEqual(self.run_tests(SCRIPT, PROGRAM), 1)
        self.assertEqual(self.run_tests("2: emulated.NeedsUmockdev\n", data=False), 1)

    def test_without_the_data_tests_may_be_skipped(self):
        self.assertEqual(self.run_tests(SCRIPT, PROGRAM, data=False), 0)

    def test_a_failed_test_fails(self):
        self.assertEqual(self.run_tests("", code=8), 8)


if __name__ == "__main__":
    unittest.main()
