// Two-finger gripper, millimetres. Frame P of the palm: origin between the jaw pads, z from the fingertips to the wrist,
// x along the jaws' travel. At opening 0 the three mesh frames coincide and the pads meet at x = 0.
// The hook of each finger (pad inwards, recess above it) makes the gripper concave.
part = "palm";

opening_max = 80;
pad = [5, 20, 15];       // thickness (x), width, height; centred on z = 0
finger = [9, 20];        // thickness and width of the blade behind the pad
finger_top = 66;         // fingers end inside the palm
palm = [116, 46, 44];    // housing
palm_bottom = 58;
wrist_d = 40;
wrist_h = 30;

module housing() {
  c = 6;
  translate([0, 0, palm_bottom]) hull() {
    translate([-palm.x / 2 + c, -palm.y / 2 + c, 0]) cube([palm.x - 2 * c, palm.y - 2 * c, palm.z]);
    translate([-palm.x / 2, -palm.y / 2, c]) cube([palm.x, palm.y, palm.z - 2 * c]);
  }
}
module wrist() translate([0, 0, palm_bottom + palm.z - 1]) cylinder(d = wrist_d, h = wrist_h + 1, $fn = 48);
module rail() translate([-palm.x / 2 + 6, -5, palm_bottom - 4]) cube([palm.x - 12, 10, 5]);

// Outline in the x-z plane of the jaw on the side of negative x.
module jaw_left() {
  b = 1.5;  // broken edges of the pad, so that it finds its way over a tab
  rotate([90, 0, 0]) translate([0, 0, -finger.y / 2]) linear_extrude(finger.y) polygon([
    [-pad.x - finger.x, finger_top], [-pad.x - finger.x, -pad.z / 2 + 4], [-pad.x - finger.x + 4, -pad.z / 2],
    [-b, -pad.z / 2], [0, -pad.z / 2 + b], [0, pad.z / 2 - b], [-b, pad.z / 2], [-pad.x, pad.z / 2 + 4],
    [-pad.x, finger_top]]);
}
module jaw_right() mirror([1, 0, 0]) jaw_left();

if (part == "palm") { union() { housing(); wrist(); rail(); } }
if (part == "jaw_left") jaw_left();
if (part == "jaw_right") jaw_right();
