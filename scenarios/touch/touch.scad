// Parts of the scenario `touch`, millimetres. Each part is in its own mesh frame; scenario.xml places it.
part = "plate";

ball_d = 20;
plate = [400, 240, 20];   // top face at z = 0
ledge = [60, 60, 30];     // stands on the plate: the box whose edge is felt
bumper = [20, 120, 80];   // stops the block
block = 50;               // free cube, origin in its centre
pad_d = 44;               // sprung push pad
lever_t = 8;              // lever: a blade through a slit of the plate, with a wide head
lever_l = 50;             // from the hinge axis (y), below the plate's face, to the top
lever_foot = 18;          // depth of the hinge axis
slit = [48, 8];           // narrow enough for the ball to pass over
slits = [[-20, -70], [40, 70]];

module blade(width, low, high) {
  hull() {
    for (z = [low + lever_t / 2, high - lever_t / 2])
      translate([0, 0, z]) rotate([90, 0, 0]) cylinder(d = lever_t, h = width, center = true, $fn = 24);
  }
}

if (part == "plate") {  // top face at z = 0
  difference() {
    translate([-plate.x / 2, -plate.y / 2, -plate.z]) cube(plate);
    for (s = slits) translate([s.x - slit.x / 2, s.y - slit.y / 2, -plate.z - 8]) cube([slit.x, slit.y, plate.z + 9]);
  }
}
if (part == "ledge") translate([-ledge.x / 2, -ledge.y / 2, 0]) cube(ledge);
if (part == "bumper") translate([-bumper.x / 2, -bumper.y / 2, 0]) cube(bumper);
if (part == "ball") sphere(d = ball_d, $fn = 64);
if (part == "pad") {  // origin in the middle of its underside
  rotate_extrude($fn = 64) polygon([[0, 0], [pad_d / 2, 0], [pad_d / 2, 7], [pad_d / 2 - 1, 8], [0, 8]]);
}
if (part == "lever") {  // origin on the hinge axis, which is y
  union() {
    blade(6, -lever_t / 2, lever_l - 2);
    blade(24, lever_foot + 5, lever_l);
  }
}
if (part == "block") {  // edges broken by 2 mm, so that a corner never meets a plane as a point
  hull() {
    cube([block, block - 4, block - 4], center = true);
    cube([block - 4, block, block - 4], center = true);
    cube([block - 4, block - 4, block], center = true);
  }
}
