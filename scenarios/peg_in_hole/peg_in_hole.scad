// Parts of the scenario `peg_in_hole`, millimetres.
part = "peg";

peg_d = 20;
clearance = 0.5;        // on the diameter
tight_clearance = 0.1;  // of the tight hole
peg_l = 60;
peg_chamfer = 1.5;
collar_d = 32;
grip = [20, 30, 44];
hole_depth = 40;
hole_chamfer = 2;
block = [30, 30, 45];   // top face at z = 0
sides = 128;            // a 128-gon is 6 um from its circle at this diameter

// Hole: the polygon is drawn around the circle, so that it is nowhere narrower than asked.
module hole(clearance) {
  r = (peg_d + clearance) / 2 / cos(180 / sides);
  rotate_extrude($fn = sides) polygon([
    [0, -hole_depth], [r, -hole_depth], [r, -hole_chamfer], [r + hole_chamfer + 0.1, 0.1], [0, 0.1]]);
}

module block_with_hole(clearance) {
  difference() {
    translate([-block.x / 2, -block.y / 2, -block.z]) cube(block);
    hole(clearance);
  }
}

if (part == "hole") block_with_hole(clearance);
if (part == "hole_tight") block_with_hole(tight_clearance);
if (part == "peg") {  // origin in the middle of the tip's face, z towards the grip
  r = peg_d / 2;
  union() {
    rotate_extrude($fn = sides) polygon([
      [0, 0], [r - peg_chamfer, 0], [r, peg_chamfer], [r, peg_l], [collar_d / 2, peg_l], [collar_d / 2, peg_l + 5],
      [0, peg_l + 5]]);
    translate([-grip.x / 2, -grip.y / 2, peg_l + 4]) cube(grip);
  }
}
if (part == "table") {  // top face at z = 0
  difference() {
    translate([-130, -90, -15]) cube([260, 180, 15]);
    translate([-34, -34, -4]) cube([8, 68, 5]);
    translate([26, -34, -4]) cube([8, 68, 5]);
  }
}
