#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/pose.hpp"
#include "core/result.hpp"

namespace physics {

// A thin rectangular isotropic sheet, flat at the start. Poisson's ratio is 1/3 in the plane, that of a lattice of
// springs (aluminium foil: 0.34); bending is that of a plate with ratio 0.
//
// Defaults are chosen for a multi-layer insulation blanket; scenarios give their own.
struct ClothParams {
  double size_x_m = 0.1;
  double size_y_m = 0.1;
  int cells_x = 8;
  int cells_y = 8;
  core::Pose X_WS;  // S: middle of the sheet at the start, z normal to it
  double density_kg_per_m2 = 0.5;
  double stretch_stiffness_N_per_m = 4000.0;  // Y = Young's modulus times thickness
  double bending_stiffness_Nm = 1e-3;         // D: moment per metre of width over curvature
  double damping_per_s = 4.0;                 // of the motion relative to what holds the sheet, or to its rigid motion
  double thickness_m = 0.001;                 // nodes keep a distance of half of it from bodies
  double friction = 0.3;
  double max_substep_s = 2.5e-4;   // shorter: less numerical damping of the implicit springs, more time; no study
  glm::dvec3 acceleration_W{0.0};  // of the frame: 0 in free flight, -9.81 z on the ground
};

// Springs, bending elements and masses of the grid. Node (i, j) is number j * (cells_x + 1) + i, at
// X_WS ((i / cells_x - 1/2) size_x, (j / cells_y - 1/2) size_y, 0).
struct ClothGrid {
  struct Spring {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    double rest_m = 0.0;
    double stiffness_N_per_m = 0.0;
  };
  // Energy 1/2 c |sum of g_k x_k|^2 with weights g = (1, -2, 1) along a line of nodes or (1, -1, -1, 1) over a cell.
  struct Bend {
    std::array<std::uint32_t, 4> node{};
    std::array<double, 4> weight{};
    double stiffness_N_per_m = 0.0;
  };

  std::vector<glm::dvec3> p_W;
  std::vector<double> mass_kg;
  std::vector<Spring> springs;
  std::vector<Bend> bends;
  double highest_bending_rad_per_s = 0.0;  // bound on the frequencies of bending, by Gershgorin's theorem
};

// Error: kInvalidInput for impossible sizes, cells, stiffnesses or density, and for cells too long for the lattice.
core::Result<ClothGrid> BuildClothGrid(const ClothParams& params);

}  // namespace physics
