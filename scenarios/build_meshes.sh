#!/bin/sh
# Regenerates every mesh of the scenarios from the OpenSCAD sources, and checks each (closed, manifold, outward).
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
# glb FOLDER NAME SOURCE PART:R,G,B,METALLIC,ROUGHNESS...
glb() {
  folder=$1 name=$2 source=$3
  shift 3
  inputs=
  for input in "$@"; do
    part "$source" "${input%%:*}"
    inputs="$inputs $work/${input%%:*}.off:${input#*:}"
  done
  $tool glb "$folder/meshes/$name.glb" $inputs
}

obj touch touch/touch.scad plate ledge bumper ball pad lever block
obj peg_in_hole parts/gripper.scad palm jaw_left jaw_right
obj peg_in_hole peg_in_hole/peg_in_hole.scad table hole peg
