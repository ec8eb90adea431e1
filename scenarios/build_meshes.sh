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
# glb FOLDER NAME SOURCE PART:R,G,B,METALLIC,ROUGHNESS[,MATERIAL]...
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

obj service_robot service_robot/service_robot.scad servicer link_along link_across wrist tool ball
obj touch touch/touch.scad plate ledge bumper ball pad lever block
obj peg_in_hole parts/gripper.scad palm jaw_left jaw_right
obj peg_in_hole peg_in_hole/peg_in_hole.scad table hole hole_tight peg

m=module_replacement/module_replacement.scad
obj module_replacement parts/gripper.scad palm jaw_left jaw_right
obj module_replacement $m satellite cavity module module_wide handle cover_tabbed lever switch_base lamp \
  holder bracket
glb module_replacement satellite $m satellite_body:0.94,0.64,0.25,1.0,0.28,mli satellite_face:0.62,0.64,0.67,0.7,0.45 \
  satellite_posts:0.08,0.08,0.09,0,0.95 satellite_fittings:0.45,0.46,0.48,0.9,0.35
glb module_replacement cavity $m cavity:0.30,0.32,0.35,0.8,0.45
glb module_replacement module $m module_box:0.80,0.81,0.83,0.9,0.35 module_boss:0.85,0.38,0.10,0.2,0.5 \
  module_mark:0.10,0.25,0.55,0.1,0.5
glb module_replacement handle $m handle_peg:0.75,0.76,0.78,0.95,0.28 handle_grip:0.90,0.62,0.08,0.1,0.6
glb module_replacement cover_tabbed $m cover_patch:0.55,0.42,0.15,0.6,0.45 cover_tab:0.85,0.15,0.10,0,0.7
glb module_replacement palm parts/gripper.scad palm_housing:0.18,0.20,0.23,0.4,0.5 palm_wrist:0.55,0.56,0.58,0.9,0.35
