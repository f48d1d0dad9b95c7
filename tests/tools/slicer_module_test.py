#!/usr/bin/env python3
"""Tests the part of the module in tools/slicer that needs no 3D Slicer.

    slicer_module_test.py"""

import math
import pathlib
import py_compile
import sys
import tempfile
import unittest

MODULE = pathlib.Path(__file__).resolve().parents[2] / "tools/slicer/KerfLink"
sys.dont_write_bytecode = True
sys.path.insert(0, str(MODULE))
from KerfLinkLib import messages  # noqa: E402


def column(matrix, j):
    return [row[j] for row in matrix[:3]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


class SlicerModule(unittest.TestCase):
    def assert_near(self, a, b):
        self.assertTrue(all(math.isclose(x, y, abs_tol=1e-12) for x, y in zip(a, b)), (a, b))

    def test_all_files_compile(self):
        with tempfile.TemporaryDirectory() as folder:
            for i, file in enumerate(sorted(MODULE.rglob("*.py"))):
                py_compile.compile(str(file), cfile=f"{folder}/{i}.pyc", doraise=True)

    def test_matrix_of_a_plane_is_a_rotation_with_its_normal_as_z(self):
        for normal, x in [((0, 0, 2), (5, 0, 0)), ((1, 2, -2), (0.3, 0.4, 0.5)), ((1, 0, 0), (1, 0, 0)), ((0, 3, 0), None),
                          ((1e-6, 0, 0), (0, 1, 0))]:
            m = messages.plane_matrix((4, 5, 6), normal, x)
            axes = [column(m, j) for j in range(3)]
            length = math.sqrt(dot(normal, normal))
            self.assert_near(axes[2], [n / length for n in normal])
            self.assert_near([dot(a, b) for a in axes for b in axes], [1, 0, 0, 0, 1, 0, 0, 0, 1])
            self.assert_near(messages._cross(axes[0], axes[1]), axes[2])
            self.assertEqual(column(m, 3), [4, 5, 6])
            self.assertEqual(m[3], [0, 0, 0, 1])
        self.assert_near(column(messages.plane_matrix((0, 0, 0), (0, 0, 1), (3, 4, 7)), 0), [0.6, 0.8, 0])

    def test_planes_without_direction_are_refused(self):
        for normal in [(0, 0, 0), (math.nan, 0, 1), (math.inf, 0, 0)]:
            self.assertRaises(ValueError, messages.plane_matrix, (0, 0, 0), normal)
        self.assertRaises(ValueError, messages.plane_matrix, (0, math.inf, 0), (0, 0, 1))

    def test_names_fit_into_a_message(self):
        self.assertEqual(messages.plane_message_name("left"), "kerf_plan/left")
        self.assertEqual(messages.plane_message_name("0123456789"), "kerf_plan/0123456789")
        self.assertEqual(messages.plane_message_name("0123456789a"), "0123456789a")
        self.assertEqual(messages.plane_message_name("\u00e4" * 6), "\u00e4" * 6)  # 12 bytes

    def test_values_are_shown(self):
        text = "force_N 3.210\ntime_s 12.500\ncut_mm3 45.678\nheat.hottest_C 60.000\nodd line"
        self.assertEqual(messages.parse_values(text)["heat.hottest_C"], 60)
        self.assertEqual(messages.show_values(text), "Force 3.2 N     Time 12.5 s     Volume cut 45.7 mm\u00b3")
        self.assertEqual(messages.show_values("nothing"), "")


if __name__ == "__main__":
    unittest.main()
