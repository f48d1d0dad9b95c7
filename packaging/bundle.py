"""Copies the libraries of programs beside them, so that they run on any x86-64 Linux with glibc 2.36 and libstdc++ of GCC 12
(tools/package --portable, python/wheel_backend.py)."""

import os
import pathlib
import re
import shutil
import subprocess

# Those of the host are used: glibc; also libstdc++ and libgcc_s, because its OpenGL driver may need newer ones.
HOST = re.compile(r"linux-vdso|.*ld-linux-x86-64|lib(c|m|dl|rt|pthread|resolv|util|mvec|stdc\+\+|gcc_s)\.so")
NEWEST = {"GLIBC": (2, 36), "GLIBCXX": (3, 4, 30), "CXXABI": (1, 3, 13)}
# GLFW opens them itself.
OPENED = {"libglfw.so.3": ("libGL.so.1", "libXi.so.6", "libXrandr.so.2", "libXcursor.so.1", "libXinerama.so.1", "libXrender.so.1",
                           "libXxf86vm.so.1", "libX11-xcb.so.1")}

# Debian packages of which only headers, static libraries or data are used.
PARTS = ("libboost-dev", "libcli11-dev", "libglm-dev", "nlohmann-json3-dev")


class BundleError(Exception):
    """A library is missing, or needs a newer system than those that are supported."""


def find_libraries(files, search=""):
    """Returns the paths of the libraries that the files need, by name, but for those of the host."""
    libraries = {}
    for file in files:
        output = subprocess.run(["ldd", file], check=True, capture_output=True, text=True,
                                env={**os.environ, "LC_ALL": "C", "LD_LIBRARY_PATH": str(search)}).stdout
        for name, path in re.findall(r"^\s*(\S+) => (not found|\S+)", output, flags=re.M):
            if path == "not found":
                raise BundleError(f"{file} needs {name}, which was not found")
            if not HOST.match(name):
                libraries[name] = pathlib.Path(path)
    return libraries


def check_versions(files):
    """Raises BundleError if a file needs newer versions of the host's libraries than NEWEST."""
    output = subprocess.run(["readelf", "--version-info", "--wide", *files], check=True, capture_output=True, text=True).stdout
    for name, version in set(re.findall(r"Name: ([A-Z]+)_([\d.]+) ", output)):
        if name in NEWEST and tuple(map(int, version.split("."))) > NEWEST[name]:
            raise BundleError(f"{name}_{version} is needed, which not every supported system has")


def bundle(files, folder, search=""):
    """Copies the libraries of the files into the folder, as they are, and makes the files use them, also if LD_LIBRARY_PATH
    names others (DT_RPATH). search: folder with further libraries. Returns where the libraries come from."""
    libraries = find_libraries(files, search)
    opened = [libraries[name].parent / other for name in OPENED if name in libraries for other in OPENED[name]]
    libraries |= find_libraries(opened, search) | {path.name: path for path in opened}
    folder.mkdir(parents=True)
    copies = [pathlib.Path(shutil.copyfile(path, folder / name)) for name, path in sorted(libraries.items())]
    for file in files:
        origin = f"$ORIGIN/{os.path.relpath(folder, file.parent)}"
        subprocess.run(["patchelf", "--force-rpath", "--set-rpath", origin, file], check=True)
    for name, path in (*find_libraries(files).items(), *find_libraries(copies, folder).items()):
        if path.resolve() != (folder / name).resolve():
            raise BundleError(f"{name} is found in {path.parent} instead of {folder}")
    check_versions([*files, *copies])
    return sorted(libraries.values())


def copy_licences(paths, packages, folder):
    """Copies the licences of the Debian packages that the files are from, and of further packages, into the folder."""
    for path in paths:
        real = os.path.realpath(path)  # dpkg may know it by its path without /usr
        done = subprocess.run(["dpkg-query", "--search", real, real.removeprefix("/usr")], capture_output=True, text=True)
        packages = {*packages, *(line.split(":")[0] for line in done.stdout.splitlines())}
        if not done.stdout and not path.name.startswith("libkerf"):
            raise BundleError(f"{path} is from no package, so that its licence is not known")
    for package in packages:
        (folder / package).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(f"/usr/share/doc/{package}/copyright", folder / package)
