#!/usr/bin/env python3
"""Installs kerf into an empty folder and uses it from there as another project would: the examples are built with
find_package(), one of them with pkg-config, and their results are compared with those of `kerf run`.

    installed.py BUILD

BUILD: a build folder of kerf. Exit code 0 if everything agrees."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
EXAMPLES = ROOT / "examples"
sys.path.insert(0, str(ROOT / "tests/app/window"))
import drive  # noqa: E402


def run(*command, code=0, **options):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, stdin=subprocess.DEVNULL, **options)
    assert done.returncode == code, f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}"
    return done.stdout if code == 0 else done.stderr


def check_symbols(library):
    """What the library shows is named in a public header or is a replacement of a function of the C library."""
    headers = "\n".join(p.read_text() for p in (ROOT / "include/kerf").glob("*.h"))
    words = set(re.findall(r"[A-Za-z_][A-Za-z0-9_]*", headers)) | {"heap_guard"}
    math = set(re.findall(r"^(?:double|void) (\w+)\(", (ROOT / "src/base/core/same_math.cpp").read_text(), flags=re.M))
    assert "sin" in math
    unknown = []
    for line in run("nm", "-D", "-C", "--defined-only", library).splitlines():
        name = line.split(" ", 2)[2]
        name = re.sub(r"^(vtable|typeinfo|typeinfo name|guard variable|TLS (init|wrapper) function|virtual thunk|non-virtual thunk) (for|to) ", "", name)
        if name in math:
            continue
        match = re.match(r"(?:[\w:<>,&* ]+ )?kerf::(\w+)(?:::(\w+))?", name)
        if not match or match.group(1) not in words:
            unknown.append(name)
    assert not unknown, f"{len(unknown)} symbols belong to no public header:\n" + "\n".join(unknown[:20])


def check_members_that_take(headers, library):
    """Members for temporary objects (`F() &&`) have a prefix of their own in the symbols, which a list of names can miss."""
    count = sum(len(re.findall(r"\) &&;", path.read_text())) for path in headers.glob("*.h"))
    shown = re.findall(r"kerf::\w+::\w+(?:\[abi:cxx11\])?\([^)]*\) &&$", run("nm", "-D", "-C", "--defined-only", library), flags=re.M)
    assert count > 0 and len(set(shown)) == count, (count, shown)


CORE_USER = """cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES CXX)
find_package(kerf 0.1 REQUIRED COMPONENTS core)
add_executable(user {source})
target_link_libraries(user PRIVATE {targets})
"""


def check_core(prefix, folder, hello):
    """The component core makes the same cut with few libraries, and is not linked together with the whole library."""
    folder = folder / "core"
    folder.mkdir()

    def configure(targets, code=0):
        (folder / "CMakeLists.txt").write_text(CORE_USER.format(source=EXAMPLES / "hello_cut.cpp", targets=targets))
        return run("cmake", "-S", folder, "-B", folder / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}", code=code)
    configure("kerf::core")
    run("cmake", "--build", folder / "build")
    assert run(folder / "build/user") == hello
    loaded = run("ldd", folder / "build/user").split("\n")
    print(f"a program with kerf::core loads {len(loaded) - 1} shared objects")
    assert len(loaded) < 30 and not any(name in line for line in loaded for name in ("libvtk", "libITK", "libGL", "libsndfile")), loaded
    assert "KERF_LIBRARY" in configure("kerf::core kerf::kerf", code=1)


def check_program(prefix, folder):
    """The installed program finds what is installed with it, in any folder and without the source tree."""
    folder = folder / "anywhere"
    folder.mkdir()
    kerf = prefix / "bin/kerf"
    found = run(kerf, "run", "scenes/slot_in_block.toml", "-o", "out", "--json", cwd=folder)
    assert json.loads(found)["scene"] == "slot_in_block", found
    # A file of the current folder comes first, and one that kerf does not have is named as it was given.
    (folder / "scenes").mkdir()
    (folder / "scenes/slot_in_block.toml").write_text("title = 7\n")
    assert run(kerf, "check", "scenes/slot_in_block.toml", code=1, cwd=folder).startswith("kerf: scenes/slot_in_block.toml:1:")
    assert "scenes/none.toml: " in run(kerf, "check", "scenes/none.toml", code=1, cwd=folder)
    for outside in ("../kerf/scenes/ball_slot.toml", "../../bin/kerf"):
        assert outside in run(kerf, "check", outside, code=1, cwd=folder)
    # Results are never written into the installation.
    run(kerf, "model", "block", "-o", "volumes/block.vdb", code=1, cwd=folder)
    run(kerf, "calibrate", "examples/synthetic_forces.csv", cwd=folder)
    binaries = [p for p in prefix.rglob("*") if p.is_file() and p.read_bytes()[:4] == b"\x7fELF"]
    assert {p.name for p in binaries} >= {"kerf", "kerf_program"}, binaries
    for binary in binaries:
        assert str(ROOT).encode() not in binary.read_bytes(), f"{binary} contains the path of the source tree"


def check_language(prefix, folder):
    """The window of the installed program has its German catalogue from the installation."""
    if any(shutil.which(program) is None for program in drive.PROGRAMS):
        print("not checked: the language of the window, because Xvfb or xdotool is not installed")
        return
    settings = folder / "config/kerf/window.json"
    settings.parent.mkdir(parents=True)
    settings.write_text('{"tour_shown": true, "language": "de"}')
    environment = {"XDG_CONFIG_HOME": str(folder / "config"), "XDG_DATA_HOME": str(folder / "data")}
    with drive.Display() as display:
        window = drive.Window(display, prefix / "bin/kerf", ["practise"], folder, environment)
        window.wait_state("the list in German", lambda state: state.get("menu", "").startswith("Übungen"))
        window.quit("close")
        window.wait_end()


def main():
    build = pathlib.Path(sys.argv[1]).resolve()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="kerf_installed_"))
    try:
        prefix = folder / "usr"
        run("cmake", "--install", build, "--prefix", prefix)
        check_program(prefix, folder)
        check_language(prefix, folder)
        library = next(prefix.glob("lib*/**/libkerf.so"), None)
        assert library, "libkerf.so is not installed"
        for name in ("libkerf.so", "libkerf_core.so"):
            check_symbols(library.parent / name)
        check_members_that_take(ROOT / "include/kerf", library)

        # The sources are compiled with the warnings that a careful user enables, and with warnings as errors.
        flags = "-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"
        run("cmake", "-S", EXAMPLES, "-B", folder / "build", "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={prefix}",
            f"-DCMAKE_CXX_FLAGS={flags}", "-DCMAKE_BUILD_TYPE=Release", "-DCHECK_TICKS=ON")
        run("cmake", "--build", folder / "build", "-j", "2")
        examples = folder / "build"
        scene = EXAMPLES / "hello_cut.toml"

        # The same bits as the program.
        run(prefix / "bin/kerf", "run", scene, "-o", folder / "out")
        summary = json.loads((folder / "out/summary.json").read_text())
        hello = run(examples / "hello_cut")
        assert summary["bone"]["hash_after"] in hello, (summary["bone"], hello)
        assert f"peak force {summary['force']['peak_N']:.6g} N" in hello, (summary["force"], hello)

        check_core(prefix, folder, hello)

        # pkg-config gives the same program.
        environment = dict(os.environ, PKG_CONFIG_PATH=str(library.parent / "pkgconfig"))
        for name in ("kerf", "kerf_core"):
            options = run("pkg-config", "--cflags", "--libs", name, env=environment).split()
            run("c++", EXAMPLES / "hello_cut.cpp", "-o", folder / "hello", *options, f"-Wl,-rpath,{library.parent}")
            assert run(folder / "hello") == hello

        law = run(examples / "own_force_law", scene)
        twice = run(examples / "own_force_law", scene, "0.1")
        peaks = [float(re.search(r"peak force ([\d.]+) N", text).group(1)) for text in (law, twice)]
        assert abs(peaks[1] / peaks[0] - 2) < 1e-4, peaks  # the law is proportional to the energy; six digits are printed
        effect = run(examples / "own_effect", scene)
        assert re.search(r"worn_teeth.turns = [\d.]+ at the end", effect), effect
        device = run(examples / "own_device", scene)
        assert device.startswith("4000 ticks, removed "), device
        table = run(examples / "batch", scene)
        assert table.count("cortex of") == 3, table
        # A wrong input gives one sentence.
        assert run(examples / "batch", folder / "nothing.toml", code=1).count("\n") == 1
    finally:
        shutil.rmtree(folder)
    print("the examples were built against the installed library and agree with the program")


if __name__ == "__main__":
    main()
