"""Tests of kerf's functions that let the program work: compare, study, stability, score."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import kerf

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROGRAM = os.environ["KERF_PROGRAM"]

STUDY = """
[study]
paths = ["graze"]
holdings = ["path"]
ticks_per_case = 1000
reference_tolerance = 0.1

[[knob]]
name = "voxel_mm"
values = [0.4]
"""


class Program(unittest.TestCase):
    def test_a_recording_is_scored(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "cut.kerf"
            kerf.run(kerf.Scene.read(ROOT / "examples/hello_cut.toml"), record=path)
            printed = subprocess.run([PROGRAM, "score", str(path), "--json"], capture_output=True, text=True, check=True).stdout
            self.assertEqual(kerf.score(path), json.loads(printed))

    def test_a_scene_made_in_python_is_compared(self):
        scene = kerf.Scene.read(ROOT / "scenes/paper_block.toml").with_value("bone.block", "voxel_mm", 0.5)
        document = kerf.compare(scene, repeat=1)
        self.assertEqual(document["scene"], "paper_block")
        curves = document["curves"]
        self.assertGreater(curves["voxel_hertz_chip_N"].max(), 0)
        self.assertTrue((curves["depth_mm"][1:] > curves["depth_mm"][:-1]).all())

    def test_a_changed_scene_keeps_its_name_and_its_files(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "lower_jaw.toml"
            kerf.Bone.block((12, 6, 6), voxel_mm=0.2).write(path.with_name("bone.vdb"))
            path.write_text('[bone]\nfile = "bone.vdb"\n\n[tool]\ndiameter_mm = 10\n\n[[path.stroke]]\nstart_mm = [-12, 0, 3]\nend_mm = [0, 0, 3]\n'
                            'feed_mm_per_s = 20\ndisc_normal = [0, 1, 0]\n')
            document = kerf.stability(kerf.Scene.read(path).with_value("tool", "rpm", 6000.0), quick=True)
            self.assertEqual(document["scene"]["name"] if isinstance(document["scene"], dict) else document["scene"], "lower_jaw")
            self.assertEqual(sorted(p.name for p in path.parent.iterdir()), ["bone.vdb", "lower_jaw.toml"])

    def test_a_study_is_returned(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "study.toml"
            path.write_text(STUDY)
            output = path.with_name("output")
            document = kerf.study(path, errors_only=True, output=output)
            self.assertEqual(len(list((output / "cases").glob("*.errors.json"))), 2)  # the records that a second call continues from
        cases = document["cases"]
        self.assertEqual(sorted(cases["id"]), ["graze.path.default", "graze.path.voxel_mm-0.4"])
        coarse, fine = (cases[cases["id"] == name]["force_p95"][0] for name in ("graze.path.voxel_mm-0.4", "graze.path.default"))
        self.assertGreater(coarse, fine)  # 0.4 mm against the default of 0.1 mm

    def test_default_study_starts_and_ctrl_c_leaves_nothing_but_records(self):
        script = "import kerf\ntry:\n  kerf.study(progress=False)\nexcept KeyboardInterrupt:\n  print('interrupted')\n"
        with tempfile.TemporaryDirectory() as folder:
            environment = dict(os.environ, TMPDIR=folder)
            with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment) as process:
                while process.poll() is None and not list(pathlib.Path(folder).glob("kerf_*/plan.json")):
                    time.sleep(0.05)
                if process.poll() is None:
                    process.send_signal(signal.SIGINT)
                self.assertEqual(process.communicate(), ("interrupted\n", ""))
            for left in pathlib.Path(folder).glob("kerf_*"):
                self.assertTrue(list((left / "cases").glob("*.json")), left)

    def test_stability_is_returned_also_if_it_fails(self):
        document = kerf.stability(ROOT / "scenes/hand_held_cut.toml", quick=True)
        self.assertIn("kerf", document)

    def test_ctrl_c_ends_the_program_too(self):
        script = "import kerf\nprint('ready', flush=True)\ntry:\n  kerf.stability(r'%s')\nexcept KeyboardInterrupt:\n  print('interrupted')\n" % (
            ROOT / "scenes/hand_held_cut.toml")
        with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
            self.assertEqual(process.stdout.readline(), "ready\n")
            time.sleep(1)
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.stdout.read(), "interrupted\n")


if __name__ == "__main__":
    unittest.main()
