// What is touched of the scenario `module_replacement`, millimetres; module_replacement.py is what is seen. W: origin in the middle of cavity a's opening, z out of the
// satellite's service face. Parts are in their own mesh frames; scenario.xml places them.
part = "module";

// --- Module and cavity -------------------------------------------------------------------------------------------
module_side = 80;
module_depth = 100;
wide = 4.6;               // of the faulty module, 3 mm wider than the cavity: 81.6 + 3 - 80
clearance = 1.6;          // total, across the module
rear_chamfer = 3;         // on the module's rear edges, to find the cavity
entry_chamfer = 4;        // on the cavity's mouth
cavity_wall = 8;
cavity_floor = 0.5;       // gap under a seated module
flange = [106, 4];        // rim on the service face: side, height
opening = 104;            // in the satellite's panel: coarse voxels stay away from the module

boss_d = 42;              // hook socket on the module's front
boss_h = 15;
socket_d = 22.2;
socket_depth = 25.5;      // from the boss' face
socket_chamfer = 2.5;

// --- Handle tool -------------------------------------------------------------------------------------------------
peg_d = 20.6;             // 1.6 mm clearance in the socket
peg_l = 28;
cone = [12, 5];           // tip diameter, height
collar = [34, 6];
shaft_d = 16;
grip = [20, 30, 50];
grip_z = 60;

// --- Cover -------------------------------------------------------------------------------------------------------
sheet_t = 3;              // room for the sheet over the posts
patch = [44, 44, 2];      // rigid, sewn on the sheet
tab = [6, 30, 28];

// --- Switch ------------------------------------------------------------------------------------------------------
lever = [8, 12];          // x, y; turns about x
lever_l = 34;

sides = 96;

module box(size, z0, z1, c0 = 0) {  // square prism, lower edges chamfered by c0
  hull() {
    translate([-size.x / 2, -size.y / 2, z0 + c0]) cube([size.x, size.y, z1 - z0 - c0]);
    translate([-size.x / 2 + c0, -size.y / 2 + c0, z0]) cube([size.x - 2 * c0, size.y - 2 * c0, 1]);
  }
}

// Frame of a module: middle of its front plate, z out.
module socket() {
  r = socket_d / 2 / cos(180 / sides);
  translate([0, 0, boss_h]) rotate_extrude($fn = sides) polygon([
    [0, -socket_depth], [r, -socket_depth], [r, -socket_chamfer], [r + socket_chamfer + 0.1, 0.1], [0, 0.1]]);
}
module boss() rotate_extrude($fn = sides) polygon([
  [0, -1], [boss_d / 2, -1], [boss_d / 2, boss_h - 1], [boss_d / 2 - 1, boss_h], [0, boss_h]]);
module module_box(extra) box([module_side + extra, module_side, 0], -module_depth, 0, rear_chamfer);
module whole_module(extra = 0) difference() { union() { module_box(extra); boss(); } socket(); }

// Frame of a cavity: middle of its opening in the plane of the service face, z out.
module cavity() {
  inner = module_side + clearance;
  outer = inner + 2 * cavity_wall;
  floor_z = -module_depth - cavity_floor;
  difference() {
    union() {
      translate([-outer / 2, -outer / 2, floor_z - cavity_wall]) cube([outer, outer, cavity_wall - floor_z + 1]);
      translate([-flange[0] / 2, -flange[0] / 2, 0]) cube([flange[0], flange[0], flange[1]]);
    }
    translate([-inner / 2, -inner / 2, floor_z]) cube([inner, inner, 200]);
    hull() {
      translate([-inner / 2, -inner / 2, flange[1] - entry_chamfer]) cube([inner, inner, 0.01]);
      translate([-inner / 2 - entry_chamfer, -inner / 2 - entry_chamfer, flange[1]])
        cube([inner + 2 * entry_chamfer, inner + 2 * entry_chamfer, 0.01]);
      translate([-inner / 2 - entry_chamfer, -inner / 2 - entry_chamfer, flange[1] + 1])
        cube([inner + 2 * entry_chamfer, inner + 2 * entry_chamfer, 1]);
    }
  }
}

// Frame of the handle: middle of its tip, z towards the grip.
module handle_peg() rotate_extrude($fn = sides) polygon([
  [0, 0], [cone[0] / 2, 0], [peg_d / 2, cone[1]], [peg_d / 2, peg_l], [collar[0] / 2, peg_l],
  [collar[0] / 2, peg_l + collar[1]], [shaft_d / 2, peg_l + collar[1]], [shaft_d / 2, grip_z + 1], [0, grip_z + 1]]);
module handle_grip() {
  c = 2;
  translate([0, 0, grip_z]) hull() {
    translate([-grip.x / 2, -grip.y / 2, c]) cube([grip.x, grip.y, grip.z - 2 * c]);
    translate([-grip.x / 2 + c, -grip.y / 2 + c, 0]) cube([grip.x - 2 * c, grip.y - 2 * c, grip.z]);
  }
}

// Frame of the tab: on the face that the sheet rests on. The sheet itself is in scenario.xml.
module cover_patch() translate([-patch.x / 2, -patch.y / 2, sheet_t - 0.5]) cube(patch);
module cover_tab() {
  c = 1.5;
  hull() {
    translate([-tab.x / 2, -tab.y / 2, sheet_t - 0.5]) cube([tab.x, tab.y, tab.z + 0.5 - c]);
    translate([-tab.x / 2 + c, -tab.y / 2 + c, sheet_t]) cube([tab.x - 2 * c, tab.y - 2 * c, tab.z]);
  }
}

// --- Satellite ---------------------------------------------------------------------------------------------------
body = [800, 600, 300];
cavities = [[0, 0], [0, 190]];
posts = [[165, 76], [165, -76], [40, 76], [40, -76], [-88, 76], [-88, -76]];  // hook-and-loop, under the cover
post_h = 48;
cover_post = [340, 190];  // where the cover is put aside
cover_post_h = 60;

module openings() for (c = cavities)
  translate([c.x - opening / 2, c.y - opening / 2, -130]) cube([opening, opening, 140]);
module plate(z0, z1) translate([-body.x / 2, -body.y / 2, z0]) cube([body.x, body.y, z1 - z0]);
module velcro_posts() for (p = posts) translate([p.x - 6, p.y - 6, -1]) cube([12, 12, post_h + 1]);
module stow_post() translate([cover_post.x, cover_post.y, -1]) {
  translate([-9, -9, 0]) cube([18, 18, cover_post_h]);
  translate([-16, -16, cover_post_h - 5]) cube([32, 32, 6]);
}

if (part == "satellite") {
  difference() { plate(-body.z, 0); openings(); }
  velcro_posts();
  stow_post();
}
if (part == "cavity") cavity();
if (part == "module") whole_module();
if (part == "module_wide") whole_module(wide);
if (part == "handle") union() { handle_peg(); handle_grip(); }
if (part == "cover_tabbed") union() { cover_patch(); cover_tab(); }
if (part == "lever") hull() {  // frame: on the hinge axis, which is x
  rotate([0, 90, 0]) cylinder(d = lever.y, h = lever.x, center = true, $fn = 32);
  translate([0, 0, lever_l - lever.y / 2]) rotate([0, 90, 0]) cylinder(d = lever.y, h = lever.x, center = true, $fn = 32);
}
if (part == "switch_base") difference() {  // frame: on the service face
  box([34, 50, 0], 0, 9);
  translate([-lever.x / 2 - 2, -19, -1]) cube([lever.x + 4, 38, 20]);
}
if (part == "holder") difference() {  // where the handle rests; frame: on the service face
  box([50, 50, 0], 0, 24);
  translate([0, 0, 4]) cylinder(d = 27, h = 30, $fn = 64);
  translate([0, 0, 21]) cylinder(d1 = 27, d2 = 35, h = 4, $fn = 64);
}
if (part == "bracket") difference() {  // where a module is put; frame: on the service face
  box([116, 116, 0], 0, 12);
  translate([-30, -30, -1]) cube([60, 60, 20]);
}
