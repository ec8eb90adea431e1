#!/bin/sh
# Regenerates every collision mesh of the scenarios from the OpenSCAD sources, and checks each (closed, manifold, outward).
# Needs openscad and python3; neither is needed to build or to run, since the meshes are checked in.
set -eu
cd "$(dirname "$0")"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tool="python3 tools/mesh_tool.py"

# part SOURCE PART: exports one part to $work/PART.off (source units are millimetres).
part() { openscad -q -D "part=\"$2\"" -o "$work/$2.off" "$1"; }
# obj FOLDER SOURCE PART...
obj() {
  folder=$1 source=$2
  shift 2
  for name in "$@"; do
    part "$source" "$name"
    $tool obj "$folder/meshes/$name.obj" "$work/$name.off"
  done
}

obj service_robot service_robot/service_robot.scad servicer link_along link_across wrist tool ball
obj touch touch/touch.scad plate ledge bumper ball pad lever block
obj peg_in_hole parts/gripper.scad palm jaw_left jaw_right
obj peg_in_hole peg_in_hole/peg_in_hole.scad table hole hole_tight peg

m=module_replacement/module_replacement.scad
obj module_replacement parts/gripper.scad palm jaw_left jaw_right
obj module_replacement $m satellite cavity module module_wide handle cover_tabbed lever switch_base \
  holder bracket
