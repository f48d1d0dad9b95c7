#!/usr/bin/env python3
"""Tests what tools/tidy selects, finds and corrects, with a small project instead of kerf's build.

    tidy_test.py"""

import contextlib
import importlib.machinery
import importlib.util
import io
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

REAL = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("tidy", str(REAL / "tools/tidy"))
tool = importlib.util.module_from_spec(importlib.util.spec_from_loader("tidy", loader))
loader.exec_module(tool)

SOURCES = {"src/a/one.h": "#pragma once\ninline int* One() { return 0; }\n",
           "src/a/one.cpp": '#include "a/one.h"\nint* First() { return One(); }\n',
           "src/a/other.cpp": '#include "a/one.h"\nint* Second() { return One(); }\n',
           "src/a/two.cpp": "int* Two() { return 0; }\n",
           "src/b/three.cpp": "int* Three() { return 0; }\n",
           "tests/a/one_test.cpp": "int* Test() { return 0; }\n",
           "tests/a/two_test.cpp": "int Same(int a) { if (a > 0) { return 1; } else { return 1; } }\n"}


class Tidy(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        tool.ROOT = pathlib.Path(folder.name).resolve()
        tool.BUILD = tool.ROOT / "build/tidy"
        tool.configure = self.configure
        for name, text in SOURCES.items():
            self.write(name, text)
        for name in (".clang-tidy", "tests/.clang-tidy"):
            shutil.copy(REAL / name, tool.ROOT / name)
        self.git("init", "-q", "-b", "main")
        self.git("config", "user.name", "A")
        self.git("config", "user.email", "a@b")
        self.commit("first")

    def configure(self):
        """Writes what CMake writes: sources of a folder are compiled as one, three.cpp alone; tests contain other.cpp."""
        entries = []
        for unit, names in (("src/a", ("a/one.cpp", "a/other.cpp", "a/two.cpp")),
                            ("tests/a", ("a/one_test.cpp", "a/two_test.cpp", "a/other.cpp"))):
            file = self.write(f"build/tidy/{unit}/unity/a_0.cpp", "".join(f'#include "{name}"\n' for name in names))
            entries.append(file)
        entries.append(tool.ROOT / "src/b/three.cpp")
        shutil.copy(REAL / "tests/.clang-tidy", tool.BUILD / "tests/.clang-tidy")
        commands = [{"directory": str(tool.ROOT), "file": str(file), "command": f"c++ -I{tool.ROOT}/src -I{tool.ROOT}/tests -c {file}"} for file in entries]
        self.write("build/tidy/compile_commands.json", json.dumps(commands))

    def write(self, name, text):
        file = tool.ROOT / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        return file

    def git(self, *arguments):
        subprocess.run(["git", "-C", tool.ROOT, *arguments], check=True, capture_output=True)

    def commit(self, message):
        self.git("add", "src", "tests")
        self.git("commit", "-q", "--allow-empty", "-m", message)

    def run_tool(self, *arguments):
        """Returns the exit code and the findings, as file:line and check."""
        with contextlib.redirect_stdout(io.StringIO()) as out:
            code = tool.main([str(tool.ROOT / a) if a in SOURCES else a for a in arguments])
        left = out.getvalue().split("what is left:")[-1]
        found = [line for line in left.splitlines() if " error: " in line]
        return code, {(line.split(":")[0].removeprefix(f"{tool.ROOT}/"), line.split("[")[-1].split(",")[0]) for line in found}

    NULLS = {(name, "modernize-use-nullptr") for name in ("src/a/one.h", "src/a/two.cpp", "src/b/three.cpp")}
    TEST = ("tests/a/two_test.cpp", "bugprone-branch-clone")

    def test_all_files_are_checked_and_tests_only_for_bugs(self):
        self.assertEqual(self.run_tool(), (1, self.NULLS | {self.TEST}))

    def test_only_the_files_given_are_checked(self):
        self.assertEqual(self.run_tool("src/a/two.cpp", "tests/a/one_test.cpp"), (1, {("src/a/two.cpp", "modernize-use-nullptr")}))
        self.assertEqual(self.run_tool("tests/a/one_test.cpp"), (0, set()))
        self.assertEqual({name: (tool.ROOT / name).read_text() for name in SOURCES}, SOURCES)

    def test_a_header_is_checked_through_one_source(self):
        sources = {tool.ROOT / name for name in SOURCES if name.endswith(".cpp")}
        one, other, header = (tool.ROOT / "src/a" / name for name in ("one.cpp", "other.cpp", "one.h"))
        self.assertEqual(tool.select({header}, sources), {one})
        self.assertEqual(tool.select({header, other}, sources), {other})
        inner = self.write("src/a/inner.h", "#pragma once\n")
        self.assertEqual(tool.select({inner}, sources), set())  # nothing includes it
        self.write("src/a/one.h", '#include "a/inner.h"\n' + SOURCES["src/a/one.h"])
        self.assertEqual(tool.select({inner}, sources), {one})
        self.assertEqual(self.run_tool("src/a/one.h"), (1, {("src/a/one.h", "modernize-use-nullptr")}))

    def test_corrections_are_applied_and_the_rest_is_reported(self):
        self.assertEqual(self.run_tool("--fix"), (1, {self.TEST}))
        self.assertEqual((tool.ROOT / "src/a/one.h").read_text(), "#pragma once\ninline int* One() { return nullptr; }\n")
        self.assertEqual(self.run_tool("--fix", "src/a/one.h", "src/a/two.cpp", "src/b/three.cpp"), (0, set()))

    def test_changes_are_those_since_the_merge_base_or_of_the_newest_commits(self):
        tool.NEWEST = 2
        for name in ("src/a/one.cpp", "src/a/other.cpp", "src/a/two.cpp"):
            self.write(name, SOURCES[name] + "// changed\n")
            self.commit(name)
        self.write("src/b/three.cpp", "// not committed\n")

        def changed():
            with contextlib.redirect_stdout(io.StringIO()):
                return [name for name in tool.find_changed() if name.endswith(".cpp") and name.startswith("src")]

        newest = ["src/a/other.cpp", "src/a/two.cpp", "src/b/three.cpp"]
        self.assertEqual(changed(), newest)  # there is no origin/main
        self.git("update-ref", "refs/remotes/origin/main", "HEAD")
        self.assertEqual(changed(), newest)
        self.git("update-ref", "refs/remotes/origin/main", "HEAD~1")
        self.assertEqual(changed(), newest[1:])

    def test_staged_files_are_checked_and_no_others(self):
        self.assertEqual(self.run_tool("--staged"), (0, set()))
        self.write("src/b/three.cpp", SOURCES["src/b/three.cpp"] + "// staged\n")
        self.git("add", "src/b/three.cpp")
        self.write("src/a/two.cpp", SOURCES["src/a/two.cpp"] + "// not staged\n")
        self.assertEqual(self.run_tool("--staged"), (1, {("src/b/three.cpp", "modernize-use-nullptr")}))


if __name__ == "__main__":
    if shutil.which("clang-tidy-14") is None:
        print("skipped: clang-tidy-14, which Debian 12 has, is not installed")
        sys.exit(77)
    unittest.main()
