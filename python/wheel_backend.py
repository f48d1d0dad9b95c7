"""Builds the wheel and the source distribution of kerf (PEP 517) with CMake, from the files of a checkout or of a source
distribution. It needs the Debian packages that a headless build needs, and patchelf.

Settings of build_wheel: "python": the version of CPython, such as 3.13, and "include": the folders with its headers and those
of pybind11, separated by semicolons. Default: the interpreter that runs this, and Debian's pybind11. The environment variable
KERF_COMMIT states the commit where there is no checkout."""

import base64
import gzip
import hashlib
import io
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "packaging"))
import bundle  # noqa: E402

BUILD = ROOT / "build/wheel"
PROJECT = tomllib.loads((ROOT / "python/pyproject.toml").read_text())["project"]
VERSION = ".".join(re.findall(r"define KERF_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", (ROOT / "include/kerf/version.h").read_text()))
NAME = f"{PROJECT['name']}-{VERSION}"
METADATA = f"""Metadata-Version: 2.1
Name: {PROJECT["name"]}
Version: {VERSION}
Summary: {PROJECT["description"]}
License: {PROJECT["license"]}
Requires-Python: {PROJECT["requires-python"]}
""" + "".join(f"Requires-Dist: {name}\n" for name in PROJECT["dependencies"])
# Replaces itself by the program, without importing the package.
COMMAND = """#!python
import importlib.util, os, sys
program = os.path.join(importlib.util.find_spec("kerf").submodule_search_locations[0], "_installed/bin/kerf")
os.execv(program, [program, *sys.argv[1:]])
"""


def build_sdist(sdist_directory, config_settings=None):
    if (ROOT / ".git").exists():
        names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0")
    else:
        names = [str(path.relative_to(ROOT)) for path in ROOT.rglob("*")]
    with gzip.GzipFile(pathlib.Path(sdist_directory) / f"{NAME}.tar.gz", "wb", mtime=0) as file, \
            tarfile.open(fileobj=file, mode="w") as tar:
        def add(name, data, mode):
            info = tarfile.TarInfo(f"{NAME}/{name}")
            info.size, info.mode = len(data), mode
            tar.addfile(info, io.BytesIO(data))

        for name in sorted(names):
            path = ROOT / name
            if path.is_file() and not re.match(r"(build|out)/|(PKG-INFO|pyproject.toml)$|.*__pycache__/", name):
                add(name, path.read_bytes(), 0o755 if os.access(path, os.X_OK) else 0o644)
        add("pyproject.toml", (ROOT / "python/pyproject.toml").read_bytes().replace(b'["."]', b'["python"]'), 0o644)
        add("PKG-INFO", METADATA.encode(), 0o644)
    return f"{NAME}.tar.gz"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    settings = config_settings or {}
    python = settings.get("python", sysconfig.get_python_version()).replace(".", "")
    include = settings.get("include", sysconfig.get_path("include"))
    stage, tree = BUILD / "stage", BUILD / "tree"
    for folder in (stage, tree):
        shutil.rmtree(folder, ignore_errors=True)
    for command in (["--preset", "headless", "-B", BUILD, "-DKERF_BUILD_TESTS=OFF", "-DKERF_BUILD_PYTHON=ON",
                     f"-DKERF_PYTHON_INCLUDE={include}", f"-DKERF_COMMIT={os.environ.get('KERF_COMMIT', '')}"],
                    ["--build", BUILD, "--parallel", str(os.cpu_count()), "--target", "installable"],
                    *(["--install", BUILD, "--prefix", stage, "--strip", "--component", part]
                      for part in ("program", "data", "library", "python"))):
        subprocess.run(["cmake", *command], cwd=ROOT, check=True)
    package, dist_info = tree / "kerf", tree / f"{NAME}.dist-info"
    shutil.copytree(stage / "lib/python3/dist-packages/kerf", package)
    for part in ("bin", "libexec", "share/kerf"):
        shutil.copytree(stage / part, package / "_installed" / part)
    module = (package / "_kerf.so").rename(package / f"_kerf.cpython-{python}-x86_64-linux-gnu.so")
    programs = [package / "_installed" / name for name in ("bin/kerf", "libexec/kerf/kerf_program")]
    libraries = bundle.bundle([module, *programs], tree / "kerf.libs", search=stage / "lib")
    bundle.copy_licences(libraries, (*bundle.PARTS, "pybind11-dev"), dist_info / "licenses")
    shutil.copy(ROOT / "LICENSE", dist_info / "licenses")
    tag = f"cp{python}-cp{python}-manylinux_2_36_x86_64"
    (dist_info / "METADATA").write_text(METADATA)
    (dist_info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: kerf\nRoot-Is-Purelib: false\nTag: {tag}\n")
    scripts = tree / f"{NAME}.data/scripts"
    scripts.mkdir(parents=True)
    (scripts / "kerf").write_text(COMMAND)
    (scripts / "kerf").chmod(0o755)
    return write_wheel(tree, pathlib.Path(wheel_directory) / f"{NAME}-{tag}.whl", dist_info.name)


def write_wheel(tree, path, dist_info):
    """Writes the files of the tree and the list of them; the same files give the same bytes."""
    record = ""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        def add(name, data, mode=0o644):
            info = zipfile.ZipInfo(name)
            info.external_attr = (0o100000 | mode) << 16
            archive.writestr(info, data, zipfile.ZIP_DEFLATED)

        for file in sorted(tree.rglob("*")):
            if file.is_file():
                name, data = str(file.relative_to(tree)), file.read_bytes()
                digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
                record += f"{name},sha256={digest},{len(data)}\n"
                add(name, data, 0o755 if os.access(file, os.X_OK) else 0o644)
        add(f"{dist_info}/RECORD", record + f"{dist_info}/RECORD,,\n")
    return path.name
