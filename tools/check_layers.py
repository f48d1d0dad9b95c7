#!/usr/bin/env python3
"""Checks every #include of include/ and src/ against docs/layers.txt, and that no two headers define types of the same
name: they are linked into one program, where such types would be confused. Tests must not use the temporary folder that
all tests share, because they run in parallel. The range of a parameter must stand only in its description.

    tools/check_layers.py [ROOT]      prints each include that violates the table, each name defined twice, each test
                                      that uses the shared folder, and each second copy of a range; exits with 1 if
                                      there is any
    tools/check_layers.py --self-test plants violations in a small tree and checks that each is detected
"""

import pathlib
import re
import sys
import tempfile

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
TYPE = re.compile(r"^(?:class|struct|enum class|enum|union) (\w+)\b(?!::|<)[^;\n]*$", re.MULTILINE)  # no specialisations
CONSTANT = re.compile(r"^(?:static |inline )*(?:constexpr|const) [^=({;\n]*?\b(k[A-Z]\w*)\b(?:\[\w*\])?\s*[={(;]", re.MULTILINE)
COMMANDS = re.compile(r"\b(kerf_folder|target_link_libraries)\(([^()]*)\)")
LINKS = re.compile(r"^\s*kerf_folder\((\w+)(?:\s+DEPENDS((?:\s+[a-z_]+)+))?", re.MULTILINE)

NUMBER = r"-?\d[\d.e+']*"
RANGE_COPIES = [
    re.compile(r"\bCLI::Range\("),
    re.compile(r"\b(?:CheckRange|NumberWithin)\(.*\{\s*" + NUMBER),
    re.compile(r'"[^"]*\b(?:valid range|must be|must have|accepts|give|specify|outside the range|is not a [a-z ]*from) ' + NUMBER + r" to "
               + NUMBER + r"(?![\w.^])"),
]

LIBRARIES = [
    ("openvdb", re.compile(r"^(openvdb|nanovdb)/")),
    ("tbb", re.compile(r"^(tbb|oneapi)/")),
    ("vtk", re.compile(r"^vtk")),
    ("itk", re.compile(r"^(itk|gdcm|vnl/|itksys/)")),
    ("toml", re.compile(r"^toml\+\+/")),
    ("cli", re.compile(r"^CLI/")),
    ("hwy", re.compile(r"^hwy/")),
    ("eigen", re.compile(r"^(Eigen|unsupported/Eigen)/")),
    ("embree", re.compile(r"^rtcore\.h")),
    ("sndfile", re.compile(r"^sndfile\.h")),
    ("json", re.compile(r"^nlohmann/")),
    ("glfw", re.compile(r"^GLFW/")),
    ("imgui", re.compile(r"^(imgui|imgui_internal|imgui_stdlib|backends/imgui)")),
    ("x11", re.compile(r"^X11/")),
    ("alsa", re.compile(r"^alsa/")),
    ("sqlite", re.compile(r"^sqlite3\.h")),
    ("zip", re.compile(r"^zip\.h")),
    ("bzip2", re.compile(r"^bzlib\.h")),
    ("zlib", re.compile(r"^zlib\.h")),
    ("zstd", re.compile(r"^zstd\.h")),
    ("sodium", re.compile(r"^sodium\.h")),
    ("sleef", re.compile(r"^sleef\.h")),
    ("usb", re.compile(r"^(libusb-1\.0/|libusb\.h)")),
    ("boost", re.compile(r"^boost/")),
    # These are allowed everywhere.
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
# unistd.h has functions for files and for terminals, iostream is needed by readers that print errors to streams, and
# sys/mman.h maps files and locks memory.
ALSO_ALLOWED = {"unistd.h": "files", "iostream": "files", "csignal": "threads", "sys/mman.h": "threads"}


class Group:
    def __init__(self, name, uses, purpose):
        self.name, self.uses, self.purpose = name, uses, purpose


class Folder:
    def __init__(self, group, name, uses, libraries, system, public, purpose):
        self.group, self.name, self.uses, self.libraries, self.system, self.public = group, name, uses, libraries, system, public
        self.purpose = purpose


def close(table):
    """Adds what the included entries may include; each entry comes after everything that it may include."""
    for name, entry in table.items():
        for used in list(entry.uses):
            if used not in table or list(table).index(used) >= list(table).index(name):
                raise SystemExit(f"docs/layers.txt: {name} includes {used}, which is not listed above it")
            entry.uses |= table[used].uses


def read_table(text):
    """Returns the groups and the folders, by name. A folder's name is relative to its group and unique."""
    groups, folders = {}, {}
    for line in text.splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) == 3:
            groups[cells[0]] = Group(cells[0], set(cells[1].split()), cells[2])
            continue
        group, _, name = cells[0].partition("/")
        if len(cells) != 6 or group not in groups:
            raise SystemExit(f"docs/layers.txt: a line must be a group (three cells) or a folder (six): {line}")
        if name in folders:
            raise SystemExit(f"docs/layers.txt: two folders are called {name}")
        system = set() if cells[3] == "-" else set(cells[3].split())
        folders[name] = Folder(group, name, set(cells[1].split()), set(cells[2].split()), system, set(cells[4].split()), cells[5])
    close(groups)
    close(folders)
    for folder in folders.values():
        for used in sorted(folder.uses):
            if folders[used].group not in groups[folder.group].uses | {folder.group}:
                raise SystemExit(f"docs/layers.txt: {folder.group}/{folder.name} includes {used} of the group "
                                 f"{folders[used].group}, which {folder.group} may not")
    return groups, folders


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
    """Checks that folders linked in the CMakeLists.txt of a group are also allowed."""
    faults = []
    for lists in sorted((root / "src").glob("*/CMakeLists.txt")):
        where = lists.relative_to(root)
        for name, depends in LINKS.findall(lists.read_text(encoding="utf-8")):
            if name not in folders or folders[name].group != lists.parent.name:
                faults.append(f"{where}: {name} is not in docs/layers.txt")
                continue
            for used in depends.split():
                if used not in folders[name].uses:
                    faults.append(f"{where}: {name} may not link {used}")
        # DEPENDS is the only way to link a folder of kerf; a program may use any visible one.
        for command, arguments in COMMANDS.findall(lists.read_text(encoding="utf-8")):
            name, *words = arguments.split()
            target = name.removeprefix("kerf_")
            used = [w.removeprefix("kerf_") for w in words if w.removeprefix("kerf_") in folders and w.startswith("kerf_")]
            if target in folders and used:
                faults.append(f"{where}: {target} links {used[0]} by {command}, not by DEPENDS")
    return faults


def check_names(root):
    """Checks types defined at the left margin of headers. Types in nested namespaces are distinguished by the namespace's name."""
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


def check_constants(root):
    """Finds constants of a source file that have the name of a constant of a header that sources of its folder include.
    Several sources of a folder are compiled as one: the source's constant would hide the header's in the following ones."""
    headers = {str(path.relative_to(root / top)): path for top in ("include", "src") for path in (root / top).rglob("*.h")}

    def headers_of(sources):
        found, open_paths = {}, list(sources)
        while open_paths:
            for _, name in includes_of(open_paths.pop()):
                if name in headers and name not in found:
                    found[name] = headers[name]
                    open_paths.append(headers[name])
        return found

    faults = []
    for folder in sorted({path.parent for path in (root / "src").rglob("*.cpp")}):
        sources = sorted(folder.glob("*.cpp"))
        of_headers = {constant: name for name, path in headers_of(sources).items()
                      for constant in CONSTANT.findall(path.read_text(encoding="utf-8"))}
        faults += [f"{path.relative_to(root)}: {name} is a constant of {of_headers[name]} too" for path in sources
                   for name in CONSTANT.findall(path.read_text(encoding="utf-8")) if name in of_headers]
    return faults


def check_folders_of_tests(root):
    """Finds tests that use gtest's TempDir(), which is the same for all tests."""
    faults = []
    for path in sorted(p for p in (root / "tests").rglob("*") if p.suffix in (".h", ".cpp")):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if "TempDir(" in line:
                faults.append(f"{path.relative_to(root)}:{number}: other tests also write there: use test::Folder of support/folder.h")
    return faults


def check_ranges(root):
    """Finds ranges written as numbers outside the description of a parameter (kerf/describe.h)."""
    faults = []
    for path in sorted(p for top in ("include", "src") for p in (root / top).rglob("*") if p.suffix in (".h", ".cpp")):
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            code = line.split("//")[0]
            if any(pattern.search(code) for pattern in RANGE_COPIES):
                faults.append(f"{path.relative_to(root)}:{number}: take the range from the parameter's description")
    return faults


def check(root):
    _, folders = read_table((root / "docs/layers.txt").read_text(encoding="utf-8"))
    owner_of_public = {header: f.name for f in folders.values() for header in f.public}
    faults = check_link_graph(root, folders) + check_names(root) + check_constants(root) + check_folders_of_tests(root)
    faults += check_ranges(root)

    def folder_of(path):
        parts = path.relative_to(root).parts
        if parts[:2] == ("include", "kerf"):
            return owner_of_public.get(path.stem)
        name = parts[2] if len(parts) > 3 else None
        return name if name in folders and folders[name].group == parts[1] else None

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
        """Returns library -> chain of files, over all headers of kerf that the file includes."""
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
            if name.startswith("."):
                faults.append(f"{where}:{number}: paths of includes must start from src or include ({name})")
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
             "base | | x\n"
             "bone | base | x\n"
             "cut | bone | x\n"
             "app | cut | x\n"
             "base/core | | | - | points | x\n"
             "base/files | core | | files | | x\n"
             "bone/grid | core | openvdb | - | | x\n"
             "cut/sim | grid | | - | | x\n"
             "app/cli | sim files | cli | files terminal | | x\n")
    good = {"docs/layers.txt": table,
            "include/kerf/points.h": "#include <string>\n",
            "src/bone/grid/grids.h": "#include <openvdb/openvdb.h>\n",
            "src/bone/grid/bone.h": '#include "kerf/points.h"\n',
            "src/cut/sim/ranges.h": 'visit("a", p.a, Range{0, 9}, "x");  // CLI::Range(0, 9)\nCheckRange("a", a, kRange);\n',
            "src/bone/grid/names.h": "namespace kerf {\nstruct Known;\nclass Known final : public Base {\n};\n}\n",
            "src/bone/grid/limits.h": "inline constexpr int kKnown = 2;  // as others\n",
            "src/base/core/own.cpp": "constexpr int kKnown = 4;\n",
            "src/cut/sim/sees.cpp": '#include "bone/grid/limits.h"\n',
            "src/cut/sim/own.cpp": "constexpr int kOther = kKnown;\n  constexpr int kKnown = 3;\n",
            "src/cut/sim/names.h": "namespace kerf {\nstruct Known;\nstruct Other {\n  struct Known {};\n};\n}\n",
            "src/base/files/names.h": "namespace kerf::files {\nstruct Known {\n};\n}\n",
            "src/bone/grid/bone.cpp": '#include "bone/grid/bone.h"\n#include "bone/grid/grids.h"\n',
            "src/cut/sim/sim.h": "\n",
            "src/cut/sim/sim.cpp": '#include "bone/grid/bone.h"\n#include "kerf/points.h"\n#include <glm/glm.hpp>\n',
            "src/bone/CMakeLists.txt": "if(X)\n  kerf_folder(grid DEPENDS core LIBS X::y PCH <z.h>)\nendif()\n",
            "src/base/files/files.cpp": "#include <fstream>\n#include <unistd.h>\n",
            "src/app/cli/main.cpp": '#include <CLI/CLI.hpp>\n#include "bone/grid/bone.h"\n#include <iostream>\n'}
    # Each entry has the planted violation and the fault that must be reported.
    plants = [
        ("src/bone/grid/up.cpp", '#include "cut/sim/sim.h"\n', "src/bone/grid/up.cpp:1: grid may not include sim (cut/sim/sim.h)"),
        ("src/base/core/up.h", '\n#  include "bone/grid/bone.h"\n', "src/base/core/up.h:2: core may not include grid (bone/grid/bone.h)"),
        ("src/base/files/beside.cpp", '#include "bone/grid/bone.h"\n', "src/base/files/beside.cpp:1: files may not include grid (bone/grid/bone.h)"),
        ("include/kerf/points.h", '#include "bone/grid/bone.h"\n', "include/kerf/points.h:1: core may not include grid (bone/grid/bone.h)"),
        ("src/cut/sim/lib.cpp", "#include <openvdb/openvdb.h>\n", "src/cut/sim/lib.cpp: sim may not see openvdb (openvdb/openvdb.h)"),
        ("src/cut/sim/lib.cpp", '#include "bone/grid/grids.h"\n', "src/cut/sim/lib.cpp: sim may not see openvdb (bone/grid/grids.h > openvdb/openvdb.h)"),
        ("src/cut/sim/io.cpp", "#include <fstream>\n", "src/cut/sim/io.cpp:1: sim may not touch files (<fstream>)"),
        ("src/cut/sim/io.cpp", "#include <chrono>\n", "src/cut/sim/io.cpp:1: sim may not touch clock (<chrono>)"),
        ("src/bone/grid/io.cpp", "#include <thread>\n", "src/bone/grid/io.cpp:1: grid may not touch threads (<thread>)"),
        ("src/base/core/io.cpp", "#include <unistd.h>\n", "src/base/core/io.cpp:1: core may not touch terminal (<unistd.h>)"),
        ("src/bone/CMakeLists.txt", "kerf_folder(grid DEPENDS core sim LIBS X::y)\n", "src/bone/CMakeLists.txt: grid may not link sim"),
        ("src/bone/CMakeLists.txt", "kerf_folder(other)\n", "src/bone/CMakeLists.txt: other is not in docs/layers.txt"),
        ("src/bone/CMakeLists.txt", "kerf_folder(grid DEPENDS core LIBS kerf_sim X::y)\n",
         "src/bone/CMakeLists.txt: grid links sim by kerf_folder, not by DEPENDS"),
        ("src/bone/CMakeLists.txt", "target_link_libraries(kerf_grid PRIVATE\n  kerf_sim)\n",
         "src/bone/CMakeLists.txt: grid links sim by target_link_libraries, not by DEPENDS"),
        ("src/bone/grid/dots.cpp", '#include "../../cut/sim/sim.h"\n',
         "src/bone/grid/dots.cpp:1: paths of includes must start from src or include (../../cut/sim/sim.h)"),
        ("src/cut/CMakeLists.txt", "kerf_folder(grid)\n", "src/cut/CMakeLists.txt: grid is not in docs/layers.txt"),
        ("src/bone/new/x.cpp", "\n", "src/bone/new/x.cpp: its folder is not in docs/layers.txt"),
        ("src/cut/grid/x.cpp", "\n", "src/cut/grid/x.cpp: its folder is not in docs/layers.txt"),
        ("src/base/core/twice.h", "namespace kerf {\nstruct Known {\n};\n}\n", "src/bone/grid/names.h: Known is defined in src/base/core/twice.h too"),
        ("src/base/core/twice.h", "namespace kerf {\nenum class Other {\n};\n}\n", "src/cut/sim/names.h: Other is defined in src/base/core/twice.h too"),
        ("src/cut/sim/hides.cpp", "namespace {\nconstexpr double kKnown = 1;\n}\n",
         "src/cut/sim/hides.cpp: kKnown is a constant of bone/grid/limits.h too"),
        ("include/kerf/other.h", "\n", "include/kerf/other.h: its folder is not in docs/layers.txt"),
        ("tests/cut/sim/a_test.cpp", "\nauto f = testing::TempDir();\n",
         "tests/cut/sim/a_test.cpp:2: other tests also write there: use test::Folder of support/folder.h"),
        ("src/app/cli/option.cpp", "\noption->check(CLI::Range(0, 9));\n",
         "src/app/cli/option.cpp:2: take the range from the parameter's description"),
        ("src/cut/sim/check.cpp", 'CheckRange("edge_mm", edge_mm, {0.5, 9});\n',
         "src/cut/sim/check.cpp:1: take the range from the parameter's description"),
        ("src/cut/sim/check.cpp", 'throw Error("the edge must be 0.5 to 9 mm");\n',
         "src/cut/sim/check.cpp:1: take the range from the parameter's description"),
        ("docs/layers.txt", table + "base/late | sim | | - | | x\n",
         "docs/layers.txt: base/late includes grid of the group bone, which base may not"),
        ("docs/layers.txt", table + "bone/one | two | | - | | x\nbone/two | | | - | | x\n",
         "docs/layers.txt: one includes two, which is not listed above it"),
        ("docs/layers.txt", table + "app/grid | | | - | | x\n", "docs/layers.txt: two folders are called grid"),
    ]

    def faults_of(tree):
        with tempfile.TemporaryDirectory() as name:
            root = pathlib.Path(name)
            for path, text in tree.items():
                (root / path).parent.mkdir(parents=True, exist_ok=True)
                (root / path).write_text(text, encoding="utf-8")
            try:
                return check(root)
            except SystemExit as fault:
                return [str(fault)]

    failed = 0
    if faults_of(good):
        print("self-test: faults in a correct tree:", *faults_of(good), sep="\n  ")
        failed += 1
    for path, text, fault in plants:
        faults = faults_of({**good, path: text})
        if faults.count(fault) != 1:
            print(f"self-test: planted in {path}: {text!r}\n  wanted {fault}\n  got    {faults}")
            failed += 1
    print(f"self-test: {len(plants)} planted violations, {failed} failures")
    return failed


def main(arguments):
    if arguments in (["-h"], ["--help"]):
        print(__doc__)
        return 0
    if len(arguments) > 1 or (arguments and arguments[0].startswith("-") and arguments != ["--self-test"]):
        print("usage: tools/check_layers.py [ROOT | --self-test]", file=sys.stderr)
        return 2
    if arguments == ["--self-test"]:
        return 1 if self_test() else 0
    root = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).parent.parent).resolve()
    if not (root / "docs/layers.txt").is_file():
        print(f"check_layers: {root}: has no docs/layers.txt", file=sys.stderr)
        return 1
    faults = check(root)
    for fault in faults:
        print(fault)
    print(f"check_layers: {len(faults)} faults against docs/layers.txt, among names, and in tests")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
