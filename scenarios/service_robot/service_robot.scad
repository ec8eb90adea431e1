// Parts of the scenario `service_robot`, millimetres. Each part is in its own mesh frame; scenario.xml places it.
part = "servicer";

bus = [600, 500, 400];  // origin in its middle
link_d = 70;            // tube of a link
joint_d = 90;           // housing of a joint that turns across the arm
reach = 200;            // from joint to joint
tool = [60, 80];        // diameter and length of the last link
ball_d = 20;

$fn = 48;

if (part == "servicer") {
  union() {
    cube(bus, center = true);
    for (y = [-150, 150]) translate([0, y, bus.z / 2 - 1]) cylinder(d = 110, h = 31);  // seats of the arms
  }
}
if (part == "link_along") {  // turns about its own tube, z
  union() {
    cylinder(d = link_d, h = reach - joint_d / 2 + 10);
    translate([0, 0, 8]) cylinder(d = link_d + 10, h = 16);
  }
}
if (part == "link_across") {  // turns about z; its tube goes along y
  union() {
    cylinder(d = joint_d, h = 90, center = true);
    rotate([-90, 0, 0]) cylinder(d = link_d, h = reach);
  }
}
if (part == "wrist") {
  union() {
    cylinder(d = joint_d, h = 90, center = true);
    rotate([-90, 0, 0]) cylinder(d = link_d, h = reach / 2);
  }
}
if (part == "tool") cylinder(d = tool[0], h = tool[1]);
if (part == "ball") sphere(d = ball_d, $fn = 64);
