"""Compares the types in _kerf.pyi with the compiled module, and checks those of the package."""

import ast
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import kerf
from kerf import _kerf

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
STUB = ROOT / "python/kerf/_kerf.pyi"
# The metaclass of pybind11, and classes that are not made by calling them.
ALLOWED = """
kerf\\._kerf\\.[A-Z]\\w+
kerf\\._kerf\\.(Bone|Run|SlabSimulation|Tick|HandTick)\\.__init__
"""


def signature_of(function):
    """Returns the names of the arguments that a compiled function takes, from its docstring."""
    line = re.sub(r"^(\d+\. )?", "", function.__doc__.splitlines()[0])
    inner = line[line.index("(") + 1:line.rindex(") ->")]
    return [name.lstrip("*") for name in re.findall(r"(?:^|, )(\*\*?\w+|[A-Za-z_]\w*)(?=:|$|, )", inner)]


def arguments_of(node):
    names = [a.arg for a in node.args.args + node.args.kwonlyargs]
    return names + ([node.args.kwarg.arg] if node.args.kwarg else [])


class Types(unittest.TestCase):
    def test_arguments_of_the_stub_are_those_of_the_module(self):
        tree = ast.parse(STUB.read_text())
        checked = 0
        for owner in [tree, *(n for n in tree.body if isinstance(n, ast.ClassDef))]:
            holder = _kerf if owner is tree else getattr(_kerf, owner.name)
            for node in owner.body:
                if not isinstance(node, ast.FunctionDef) or any(getattr(d, "id", "") == "property" for d in node.decorator_list):
                    continue
                function = getattr(holder, node.name)
                known = [n for n in signature_of(function) if n not in ("self", "arg0")]
                stated = [n for n in arguments_of(node) if n != "self"]
                if known and known[-1] == "kwargs":
                    known[-1] = stated[-1]
                self.assertEqual(stated, known, f"{owner} {node.name}")
                self.assertTrue(owner is tree or function.__doc__)
                checked += 1
        self.assertGreater(checked, 60)

    def test_stub_and_package_have_every_tool(self):
        stub = {n.name: n for n in ast.parse(STUB.read_text()).body if isinstance(n, ast.ClassDef)}
        tools = {name: c for name, c in vars(_kerf).items() if isinstance(c, type) and hasattr(c, "grip_mm")}
        self.assertGreaterEqual(set(tools), {"Disc", "Ball"})
        for name, tool in tools.items():
            self.assertIs(getattr(kerf, name), tool)
            stated = [n.name for n in stub[name].body if isinstance(n, ast.FunctionDef) and not n.name.startswith("__")]
            self.assertEqual(stated, [n for n, value in vars(tool).items() if isinstance(value, property)], name)

    def test_stub_has_what_the_module_has(self):
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as allowed:
            allowed.write(ALLOWED)
            allowed.flush()
            done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "kerf._kerf", "--allowlist", allowed.name,
                                   "--ignore-unused-allowlist"], capture_output=True, text=True, env=ENVIRONMENT)
        if "No module named" in done.stderr:
            self.skipTest("mypy is not installed")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_package_keeps_its_own_types(self):
        files = sorted((ROOT / "python/kerf").glob("*.py"))
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", cache, *files], capture_output=True,
                                  text=True, env=ENVIRONMENT)
        if "No module named" in done.stderr:
            self.skipTest("mypy is not installed")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


ENVIRONMENT = dict(os.environ, MYPYPATH=str(ROOT / "python"))

if __name__ == "__main__":
    unittest.main()
