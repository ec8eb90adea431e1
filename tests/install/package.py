#!/usr/bin/env python3
"""package.py CPACK BUILD_FOLDER SOURCE_FOLDER SCRATCH_FOLDER

Makes the Debian packages and checks that they name all they need: each is unpacked into a root folder that has nothing but
what it depends on. There vr-oos runs a scenario, and programs are compiled against vr-oos-dev.
"""
import glob
import json
import os
import re
import shutil
import subprocess
import sys

import bare_machine
from debian_packages import Packages, ask, files_of, merged

SKIPPED = 77


class Wrong(Exception):
    """What does not hold."""


def require(holds, what):
    if not holds:
        raise Wrong(what)


def make_packages(cpack, build, folder):
    made = subprocess.run([cpack, "-G", "DEB", "--config", f"{build}/CPackConfig.cmake", "-B", folder],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    require(made.returncode == 0, f"cpack failed:\n{made.stdout}")
    found = {ask("dpkg-deb", "-f", file, "Package").strip(): file for file in glob.glob(f"{folder}/*.deb")}
    require(set(found) == {"vr-oos", "vr-oos-dev"}, f"the packages are {sorted(found)}")
    return found


def depends(file):
    return ask("dpkg-deb", "-f", file, "Depends").strip()


def linked(program):
    """The libraries that the loader finds for a program: name, and path or "not found"."""
    return re.findall(r"^\s+(\S+) => (not found|\S+)", ask("ldd", program), re.MULTILINE)


def check_libraries(root, owned):
    """Every library of every program comes with a package that vr-oos depends on, or with vr-oos."""
    programs = [file for file in glob.glob(f"{root}/usr/libexec/vr-oos/*") if open(file, "rb").read(4) == b"\x7fELF"]
    require(len(programs) >= 8, f"only these programs are in the package: {programs}")
    for program in programs:
        for name, path in linked(program):
            here = path.startswith(root) or merged(path) in owned or merged(os.path.realpath(path)) in owned
            require(here, f"{os.path.basename(program)} needs {name} ({path}), of no package that vr-oos depends on")
    print(f"{len(programs)} programs: every library is of a package in Depends, or of one that those need")


def run(machine, *words, status=0):
    ran = subprocess.run([*machine, *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, stdin=subprocess.DEVNULL)
    require(ran.returncode == status, f"{' '.join(words)}: status {ran.returncode}\n{ran.stdout}")
    return ran.stdout


def check_runs(machine, results, root):
    """A scenario by its name, in one process, then as five nodes with a picture. `results`: a folder, as the machine sees it."""
    version = run(machine, "oos", "--version")
    require(re.fullmatch(r"oos \d+\.\d+\.\d+ \(\S+\)\n", version), f"oos --version says {version}")
    print(version, end="")
    alone = run(machine, "oos", "run", "touch", "--lockstep", "--out", f"{results}/alone")
    require("\ncompleted\n" in alone, f"touch in lock-step is not completed:\n{alone}")
    # Time enough to press the plate; so the run is not completed, which is status 1.
    live = run(machine, "oos", "run", "touch", "--headless", "--duration", "4", "--out", f"{results}/live", status=1)
    require("NOT completed: limit of 4 s reached" in live, f"touch does not run to its limit:\n{live}")
    pictures = json.load(open(f"{root}/results/live/visual_node.json"))["frames"]
    require(pictures > 0, "visual_node drew no picture")
    print(f"touch completed in lock-step, and ran as five nodes, {pictures} pictures drawn")


def check_compiles(machine):
    """Every public header, and all three libraries, in one program; and examples/wrench, both built as a stranger would."""
    for project in ("headers", "wrench"):
        run(machine, "cmake", "-S", f"/elsewhere/{project}", "-B", f"/elsewhere/{project}/build", "-G", "Ninja",
            "-DCMAKE_CXX_COMPILER=g++", "-DCMAKE_BUILD_TYPE=Release")
        run(machine, "cmake", "--build", f"/elsewhere/{project}/build")
    force = run(machine, "/elsewhere/wrench/build/wrench", "/elsewhere/meshes/ball.obj", "/elsewhere/meshes/plate.obj", "0", "0", "0.009")
    require(force.startswith("force_N"), f"the example says {force}")
    print("vr-oos-dev: a program of all headers and libraries, and the example, compile and run")


_HEADERS = """cmake_minimum_required(VERSION 3.25)
project(headers LANGUAGES CXX)
find_package(vr_oos REQUIRED)
add_executable(headers main.cpp)
target_compile_options(headers PRIVATE -O0)
target_link_libraries(headers PRIVATE vr_oos::vps vr_oos::physics vr_oos::bus)
"""


def is_whole(header):
    """Headers without it are parts of a file, which some .cpp includes in its middle."""
    return "#pragma once" in open(header).read()


def write_projects(root, source):
    """The sources of check_compiles, in the machine's folder /elsewhere."""
    include = f"{root}/usr/include/vr_oos/"
    headers = sorted(file[len(include):] for file in glob.glob(f"{include}**/*.hpp", recursive=True) if is_whole(file))
    require(len(headers) > 100, f"only {len(headers)} headers are in vr-oos-dev")
    os.makedirs(f"{root}/elsewhere/headers")
    with open(f"{root}/elsewhere/headers/CMakeLists.txt", "w") as file:
        file.write(_HEADERS)
    with open(f"{root}/elsewhere/headers/main.cpp", "w") as file:
        file.write("".join(f'#include "{header}"\n' for header in headers) + "int main() {}\n")
    shutil.copytree(f"{source}/examples/wrench", f"{root}/elsewhere/wrench")
    shutil.copytree(f"{source}/scenarios/touch/meshes", f"{root}/elsewhere/meshes")


def make_machine(file, more, root):
    """A root folder with a package, what it depends on and what every Debian has. Returns the files of the latter two."""
    packages = Packages()
    owned = files_of(packages.closure(", ".join([depends(file), more, *packages.essential])))
    bare_machine.build(root, owned)
    subprocess.run(["dpkg-deb", "-x", file, root], check=True)
    return owned


def test_runtime(file, root):
    owned = make_machine(file, "", root)
    check_libraries(root, owned)
    hindrance = bare_machine.why_not(root)
    if hindrance:
        check_runs(["env", "-i", f"PATH={root}/usr/bin:/usr/bin:/bin", f"HOME={root}/tmp"], f"{root}/results", root)
    else:
        check_runs(bare_machine.enter(root), "/results", root)
    return hindrance


def test_development(file, root, source):
    make_machine(file, "g++, cmake, ninja-build", root)
    write_projects(root, source)
    check_compiles(bare_machine.enter(root))


def test(cpack, build, source, scratch):
    """Returns the exit status."""
    made = make_packages(cpack, build, f"{scratch}/made")
    hindrance = test_runtime(made["vr-oos"], f"{scratch}/vr-oos")
    if hindrance:
        print(f"vr-oos ran beside what else is installed here, vr-oos-dev was not tried: no machine of its own: {hindrance}")
        return SKIPPED
    test_development(made["vr-oos-dev"], f"{scratch}/vr-oos-dev", source)
    return 0


def main(cpack, build, source, scratch):
    shutil.rmtree(scratch, ignore_errors=True)
    os.makedirs(scratch)
    try:
        return test(cpack, build, source, scratch)
    except (Wrong, LookupError) as wrong:
        print(f"FAILED: {wrong}")
        return 1
    finally:
        shutil.rmtree(scratch)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
