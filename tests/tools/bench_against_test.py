#!/usr/bin/env python3
"""Tests how tools/bench_against compares two programs, with programs whose times are known.

    bench_against_test.py"""

import importlib.machinery
import importlib.util
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools/bench_against"
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("bench_against", str(TOOL))
tool = importlib.util.module_from_spec(importlib.util.spec_from_loader("bench_against", loader))
loader.exec_module(tool)


class BenchAgainst(unittest.TestCase):
    def test_programs_run_in_turn_and_ratios_are_those_of_the_rounds(self):
        # In the third round the machine is ten times slower: the ratio is not.
        times = {"old": iter([20, 30, 200]), "new": iter([10, 10, 100])}
        order = []

        def measure(program):
            order.append(program)
            return {"times": {"p50_us": next(times[program])}}

        figure = tool.summarize(tool.compare("old", "new", 3, measure))["p50_us"]
        self.assertEqual(order, ["old", "new", "new", "old", "old", "new"])
        self.assertEqual(figure, {"before": 30, "after": 10, "times_faster": 2, "least": 2, "most": 3})

    def test_table_states_whether_the_bone_is_the_same(self):
        def case(bones):
            rounds = {side: [{"times": dict.fromkeys(tool.PERCENTILES, time), "bone": bone, "times_faster_than_baseline": None}]
                      for side, time, bone in (("before", 50, bones[0]), ("after", 20, bones[1]))}
            return {"figures": tool.summarize(rounds), "rounds": rounds}

        same, changed = tool.make_tick_table({"a": case("xx"), "b": case("xy")}, "1", "2")[2:]
        self.assertEqual(same, "| a | 50 / 50 / 50 | 20 / 20 / 20 | **2.50** (2.50 to 2.50) | **2.50** (2.50 to 2.50) |  | "
                               "the same, `x` |")
        self.assertIn("`x` -> `y`", changed)

    def test_case_is_read_from_the_report_of_the_tick(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "kerf"
            program.write_text("#!/bin/sh\n[ \"$*\" = 'bench tick --case c --ticks 7 --json' ] || exit 1\n"
                               """echo '{"cases": [{"tick": {"p50_us": 1, "p99_us": 2, "p999_us": 3, "max_us": 4, "ticks": 7},"""
                               """ "baseline": {"times_faster": 5}, "bone_hash": "ab"}]}'\n""", encoding="utf-8")
            program.chmod(0o755)
            options = types.SimpleNamespace(ticks=7, realtime=False)
            self.assertEqual(tool.measure_case(program, "c", options),
                             {"times": {"p50_us": 1, "p99_us": 2, "p999_us": 3}, "times_faster_than_baseline": 5, "bone": "ab"})
            with self.assertRaisesRegex(tool.Failure, "failed"):
                tool.measure_case(program, "d", options)

    def test_command_is_measured_with_all_that_it_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "kerf"
            program.write_text("#!/bin/sh\n[ \"$1\" = run ] || { echo bad; exit 1; }\nmkdir -p \"$2/deep\"\n"
                               "head -c 3000000 /dev/zero > \"$2/deep/file\"\nsleep 0.2\n", encoding="utf-8")
            program.chmod(0o755)
            times = tool.measure_command(program, "run {out}")["times"]
            self.assertEqual(times["output_MB"], 3)
            self.assertGreaterEqual(times["wall_s"], 0.2)
            self.assertLess(times["cpu_s"], times["wall_s"])
            with self.assertRaisesRegex(tool.Failure, "bad"):
                tool.measure_command(program, "walk")


    def test_cases_without_times_and_bones_that_differ_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "kerf"
            program.write_text("#!/bin/sh\necho '{\"cases\": [{\"tick\": null, \"baseline\": null, \"bone_hash\": null}]}'\n",
                               encoding="utf-8")
            program.chmod(0o755)
            with self.assertRaisesRegex(tool.Failure, "states no times"):
                tool.measure_case(program, "memory", types.SimpleNamespace(ticks=7, realtime=False))
        rounds = [{"times": dict.fromkeys(tool.PERCENTILES, 1), "bone": bone, "times_faster_than_baseline": None} for bone in "xy"]
        both = {"before": rounds, "after": rounds[:1] * 2}
        self.assertIn("`x` or `y` -> `x`", tool.make_tick_table({"a": {"figures": tool.summarize(both), "rounds": both}}, "", "")[2])

    def test_wrong_usage_ends_before_anything_is_built(self):
        for arguments, message in ((["no_such_revision"], "no revision"), (["HEAD", "--rounds", "0"], "at least 1"),
                                   (["HEAD", "--command", "run 'a {out}"], "quotation mark"),
                                   (["HEAD", "--command", "run a"], "must name {out}"), (["HEAD", "-o", "no/such/file"], "does not")):
            done = subprocess.run([sys.executable, TOOL, *arguments], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
            self.assertIn(message, done.stderr)


if __name__ == "__main__":
    unittest.main()
