#!/usr/bin/env python3
"""Makes the visual meshes of the scenarios from their parametric sources.

  make_visuals.py [FILE...]        writes them (all, or those named) and says their sizes
  make_visuals.py --check          compares what the sources make with what is checked in; exit status 1 when they differ

Python's standard library is enough. The same sources make the same bits.
"""
import importlib.util
import pathlib
import sys

SCENARIOS = pathlib.Path(__file__).resolve().parent.parent
SOURCES = ["module_replacement/module_replacement.py", "parts/gripper.py", "parts/arm.py", "parts/hand.py",
           "peg_in_hole/peg_in_hole.py", "service_robot/service_robot.py"]


def parts():
    """Relative file: function that makes its Model."""
    sys.path.insert(0, str(SCENARIOS / "tools"))
    sys.dont_write_bytecode = True
    found = {}
    for source in SOURCES:
        spec = importlib.util.spec_from_file_location(pathlib.Path(source).stem, SCENARIOS / source)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        found.update(module.PARTS)
    return found


def main(arguments):
    is_check = arguments == ["--check"]
    wanted = [] if is_check else [pathlib.Path(a).name for a in arguments]
    status = total = 0
    for name, make in parts().items():
        if wanted and pathlib.Path(name).name not in wanted:
            continue
        model = make()
        data = model.data()
        total += len(data)
        file = SCENARIOS / name
        if not is_check:
            file.write_bytes(data)
            print(f"{name}: {model.what()}, {len(data)} bytes")
        elif not file.exists() or file.read_bytes() != data:
            print(f"{name} is not what its source makes: run scenarios/tools/make_visuals.py and look at the picture")
            status = 1
    print(f"{total} bytes")
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
