#!/usr/bin/env python3
"""Holds every #include of include/ and src/ against docs/layers.txt, and the names of types that headers define against each other:
one program has all of them, so that two of one name would be one to the linker. And no test may use the folder that all tests share:
they run beside each other.

    tools/check_layers.py [ROOT]      exit 1 and a line for each include that goes against the table, each name given twice, and each
                                      test in the shared folder
    tools/check_layers.py --self-test plants violations in a small tree and checks that each is caught
"""

import pathlib
import re
import sys
import tempfile

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
TYPE = re.compile(r"^(?:class|struct|enum class|enum|union) (\w+)\b(?!::)[^;\n]*$", re.MULTILINE)
LINKS = re.compile(r"^kerf_folder\((\w+)(?:\s+DEPENDS((?:\s+[a-z]+)+))?", re.MULTILINE)

LIBRARIES = [
    ("openvdb", re.compile(r"^(openvdb|nanovdb)/")),
    ("tbb", re.compile(r"^(tbb|oneapi)/")),
    ("vtk", re.compile(r"^vtk")),
    ("itk", re.compile(r"^(itk|gdcm|vnl/|itksys/)")),
    ("toml", re.compile(r"^toml\+\+/")),
    ("cli", re.compile(r"^CLI/")),
    ("hwy", re.compile(r"^hwy/")),
    ("embree", re.compile(r"^embree3/")),
    ("sndfile", re.compile(r"^sndfile\.h")),
    ("json", re.compile(r"^nlohmann/")),
    ("glfw", re.compile(r"^GLFW/")),
    ("alsa", re.compile(r"^alsa/")),
    ("sqlite", re.compile(r"^sqlite3\.h")),
    ("zstd", re.compile(r"^zstd\.h")),
    ("sodium", re.compile(r"^sodium\.h")),
    ("sleef", re.compile(r"^sleef\.h")),
    ("usb", re.compile(r"^(libusb-1\.0/|libusb\.h)")),
    ("boost", re.compile(r"^boost/")),
    # Free to all.
    ("", re.compile(r"^(glm|fmt)/")),
]
SYSTEM = {
    "files": {"fstream", "filesystem", "cstdio", "stdio.h", "fcntl.h", "sys/stat.h", "sys/mman.h", "dirent.h"},
    "clock": {"chrono", "ctime", "time.h", "sys/time.h", "sys/resource.h"},
    "threads": {"thread", "mutex", "shared_mutex", "future", "condition_variable", "semaphore", "pthread.h", "sched.h",
                "sys/prctl.h"},
    "sockets": {"sys/socket.h", "netinet/in.h", "arpa/inet.h", "netdb.h", "sys/un.h"},
    "terminal": {"iostream", "unistd.h", "csignal", "termios.h", "sys/ioctl.h"},
}
# unistd.h holds both files and terminals; iostream is what others' readers throw their messages at; sys/mman.h maps files and locks
# memory.
ALSO_ALLOWED = {"unistd.h": "files", "iostream": "files", "csignal": "threads", "sys/mman.h": "threads"}


class Folder:
    def __init__(self, name, uses, libraries, system, public):
        self.name, self.uses, self.libraries, self.system, self.public = name, uses, libraries, system, public


def read_table(text):
    folders = {}
    for line in text.splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) != 6:
            raise SystemExit(f"docs/layers.txt: not six cells: {line}")
        uses = set(cells[1].split())
        for used in uses:
            if used not in folders:
                raise SystemExit(f"docs/layers.txt: {cells[0]} includes {used}, which does not stand above it")
        system = set() if cells[3] == "-" else set(cells[3].split())
        folders[cells[0]] = Folder(cells[0], uses, set(cells[2].split()), system, set(cells[4].split()))
    # What a folder may include, its folders may bring along.
    for folder in folders.values():
        folder.uses |= set().union(*(folders[used].uses for used in folder.uses)) if folder.uses else set()
    return folders


def includes_of(path):
    found = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            found.append((number, match.group(2)))
    return found


def library_of(name):
    for library, pattern in LIBRARIES:
        if pattern.match(name):
            return library
    return None


def check_link_graph(root, folders):
    """The folders that src/CMakeLists.txt links must be allowed too."""
    lists = root / "src/CMakeLists.txt"
    if not lists.is_file():
        return []
    faults = []
    for name, depends in LINKS.findall(lists.read_text(encoding="utf-8")):
        if name not in folders:
            faults.append(f"src/CMakeLists.txt: {name} is not in docs/layers.txt")
            continue
        for used in depends.split():
            if used not in folders[name].uses:
                faults.append(f"src/CMakeLists.txt: {name} may not link {used}")
    return faults


def check_names(root):
    """Types at the left margin of headers; those of namespaces within kerf's are told apart by the namespace's name."""
    faults = []
    seen = {}
    for path in sorted(p for top in ("include", "src") for p in (root / top).rglob("*.h")):
        text = path.read_text(encoding="utf-8")
        within = re.search(r"^namespace (kerf::\w+|(?!kerf\b)\w+) {", text, re.MULTILINE)
        where = path.relative_to(root)
        for name in TYPE.findall(text):
            first = seen.setdefault((within and within.group(1), name), where)
            if first != where:
                faults.append(f"{where}: {name} is defined in {first} too")
    return faults


def check_folders_of_tests(root):
    """gtest's TempDir() is the same for all."""
    faults = []
    for path in sorted(p for p in (root / "tests").rglob("*") if p.suffix in (".h", ".cpp")):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if "TempDir(" in line:
                faults.append(f"{path.relative_to(root)}:{number}: other tests write there too: take a test::Folder of support/folder.h")
    return faults


def check(root):
    folders = read_table((root / "docs/layers.txt").read_text(encoding="utf-8"))
    owner_of_public = {header: f.name for f in folders.values() for header in f.public}
    faults = check_link_graph(root, folders) + check_names(root) + check_folders_of_tests(root)

    def folder_of(path):
        parts = path.relative_to(root).parts
        if parts[:2] == ("include", "kerf"):
            return owner_of_public.get(path.stem)
        return parts[1] if len(parts) > 2 else None

    files = sorted(p for top in ("include", "src") for p in (root / top).rglob("*") if p.suffix in (".h", ".cpp", ".in"))
    includes = {}
    for path in files:
        where = path.relative_to(root)
        if folder_of(path) not in folders:
            faults.append(f"{where}: its folder is not in docs/layers.txt")
            continue
        includes[path] = includes_of(path)

    def target_of(name):
        for base in (root / "include", root / "src"):
            if (base / name).is_file():
                return base / name
        return None

    reached = {}

    def libraries_reached(path):
        """Library -> chain of files, over all headers of ours that the file includes."""
        if path in reached:
            return reached[path]
        reached[path] = {}
        for _, name in includes.get(path, []):
            library = library_of(name)
            if library:
                reached[path].setdefault(library, name)
            target = target_of(name)
            if target is not None:
                for further, chain in libraries_reached(target).items():
                    reached[path].setdefault(further, f"{name} > {chain}")
        return reached[path]

    for path in files:
        if path not in includes:
            continue
        me = folders[folder_of(path)]
        where = path.relative_to(root)
        for number, name in includes[path]:
            target = target_of(name)
            if target is not None:
                other = folder_of(target)
                if other in folders and other != me.name and other not in me.uses:
                    faults.append(f"{where}:{number}: {me.name} may not include {other} ({name})")
            for group, headers in SYSTEM.items():
                if name in headers and group not in me.system and ALSO_ALLOWED.get(name) not in me.system:
                    faults.append(f"{where}:{number}: {me.name} may not touch {group} (<{name}>)")
        for library, chain in libraries_reached(path).items():
            if library not in me.libraries:
                faults.append(f"{where}: {me.name} may not see {library} ({chain})")
    return faults


def self_test():
    table = ("# a comment\n"
             "core | | | - | base | x\n"
             "bone | core | openvdb | - | | x\n"
             "sim | bone | | - | | x\n"
             "files | core | | files | | x\n"
             "app | sim files | cli | files terminal | | x\n")
    good = {"docs/layers.txt": table,
            "include/kerf/base.h": "#include <string>\n",
            "src/bone/grids.h": "#include <openvdb/openvdb.h>\n",
            "src/bone/bone.h": '#include "kerf/base.h"\n',
            "src/bone/names.h": "namespace kerf {\nstruct Known;\nclass Known final : public Base {\n};\n}\n",
            "src/sim/names.h": "namespace kerf {\nstruct Known;\nstruct Other {\n  struct Known {};\n};\n}\n",
            "src/files/names.h": "namespace kerf::files {\nstruct Known {\n};\n}\n",
            "src/bone/bone.cpp": '#include "bone/bone.h"\n#include "bone/grids.h"\n',
            "src/sim/sim.cpp": '#include "bone/bone.h"\n#include "kerf/base.h"\n#include <glm/glm.hpp>\n',
            "src/CMakeLists.txt": "kerf_folder(core)\nkerf_folder(bone DEPENDS core LIBS X::y PCH <z.h>)\n",
            "src/files/files.cpp": "#include <fstream>\n#include <unistd.h>\n",
            "src/app/main.cpp": '#include <CLI/CLI.hpp>\n#include "bone/bone.h"\n#include <iostream>\n'}
    # Each: what is planted, and the fault that it must bring.
    plants = [
        ("src/bone/up.cpp", '#include "sim/sim.h"\n', "src/bone/up.cpp:1: bone may not include sim (sim/sim.h)"),
        ("src/core/up.h", '\n#  include "bone/bone.h"\n', "src/core/up.h:2: core may not include bone (bone/bone.h)"),
        ("src/files/beside.cpp", '#include "bone/bone.h"\n', "src/files/beside.cpp:1: files may not include bone (bone/bone.h)"),
        ("include/kerf/base.h", '#include "bone/bone.h"\n', "include/kerf/base.h:1: core may not include bone (bone/bone.h)"),
        ("src/sim/lib.cpp", "#include <openvdb/openvdb.h>\n", "src/sim/lib.cpp: sim may not see openvdb (openvdb/openvdb.h)"),
        ("src/sim/lib.cpp", '#include "bone/grids.h"\n', "src/sim/lib.cpp: sim may not see openvdb (bone/grids.h > openvdb/openvdb.h)"),
        ("src/sim/io.cpp", "#include <fstream>\n", "src/sim/io.cpp:1: sim may not touch files (<fstream>)"),
        ("src/sim/io.cpp", "#include <chrono>\n", "src/sim/io.cpp:1: sim may not touch clock (<chrono>)"),
        ("src/bone/io.cpp", "#include <thread>\n", "src/bone/io.cpp:1: bone may not touch threads (<thread>)"),
        ("src/core/io.cpp", "#include <unistd.h>\n", "src/core/io.cpp:1: core may not touch terminal (<unistd.h>)"),
        ("src/CMakeLists.txt", "kerf_folder(bone DEPENDS core sim LIBS X::y)\n", "src/CMakeLists.txt: bone may not link sim"),
        ("src/CMakeLists.txt", "kerf_folder(other)\n", "src/CMakeLists.txt: other is not in docs/layers.txt"),
        ("src/new/x.cpp", "\n", "src/new/x.cpp: its folder is not in docs/layers.txt"),
        ("src/core/twice.h", "namespace kerf {\nstruct Known {\n};\n}\n", "src/core/twice.h: Known is defined in src/bone/names.h too"),
        ("src/core/twice.h", "namespace kerf {\nenum class Other {\n};\n}\n", "src/sim/names.h: Other is defined in src/core/twice.h too"),
        ("include/kerf/other.h", "\n", "include/kerf/other.h: its folder is not in docs/layers.txt"),
        ("tests/sim/a_test.cpp", "\nauto f = testing::TempDir();\n",
         "tests/sim/a_test.cpp:2: other tests write there too: take a test::Folder of support/folder.h"),
    ]

    def faults_of(tree):
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name)
            for path, text in {**tree, "src/sim/sim.h": "\n"}.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(text, encoding="utf-8")
            return check(root)

    failed = 0
    if faults_of(good):
        print("self-test: the good tree is refused:", *faults_of(good), sep="\n  ")
        failed += 1
    for path, text, fault in plants:
        faults = faults_of({**good, path: text})
        if faults.count(fault) != 1:
            print(f"self-test: planted in {path}: {text!r}\n  wanted {fault}\n  got    {faults}")
            failed += 1
    print(f"self-test: {len(plants)} planted violations, {failed} failures")
    return failed


def main(arguments):
    if arguments == ["--self-test"]:
        return 1 if self_test() else 0
    root = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).parent.parent).resolve()
    faults = check(root)
    for fault in faults:
        print(fault)
    print(f"check_layers: {len(faults)} faults against docs/layers.txt, among names of types, and in tests")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
