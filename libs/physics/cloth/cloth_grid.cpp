#include "physics/cloth/cloth_grid.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace physics {
namespace {

constexpr int kMaxCells = 255;

core::Result<void> Check(const ClothParams& p) {
  const auto fail = [](const std::string& what) -> core::Result<void> {
    return core::Fail(core::ErrorCode::kInvalidInput, "cloth: " + what);
  };
  const auto is_positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  if (p.cells_x < 2 || p.cells_y < 2 || p.cells_x > kMaxCells || p.cells_y > kMaxCells) {
    return fail(std::to_string(p.cells_x) + " x " + std::to_string(p.cells_y) +
                " cells; a sheet has 2 to 255 along each side");
  }
  if (!is_positive(p.size_x_m) || !is_positive(p.size_y_m)) return fail("a side is not above zero; give metres");
  if (!is_positive(p.density_kg_per_m2)) return fail("density_kg_per_m2 is not above zero; a blanket has 0.2 to 1");
  if (!is_positive(p.stretch_stiffness_N_per_m)) return fail("stretch stiffness is not above zero");
  if (!(p.bending_stiffness_Nm >= 0.0) || !(p.damping_per_s >= 0.0) || !(p.thickness_m >= 0.0) ||
      !(p.friction >= 0.0)) {
    return fail("bending stiffness, damping, thickness and friction must be 0 or more");
  }
  if (!is_positive(p.max_substep_s)) return fail("max_substep_s is not above zero");
  const double ratio = (p.size_x_m / p.cells_x) / (p.size_y_m / p.cells_y);
  if (ratio > 1.7 || ratio < 1.0 / 1.7) {
    return fail(
        "its cells are " + std::to_string(ratio) +
        " times as long as wide, but the springs of the lattice need a ratio from 0.6 to 1.7; change the number "
        "of cells along a side");
  }
  return {};
}

class Builder {
 public:
  explicit Builder(const ClothParams& params)
      : p_(params), a_(params.size_x_m / params.cells_x), b_(params.size_y_m / params.cells_y) {}

  ClothGrid Build() {
    AddNodes();
    AddSprings();
    AddBends();
    BoundFrequency();
    return std::move(grid_);
  }

 private:
  [[nodiscard]] std::uint32_t Node(int i, int j) const { return static_cast<std::uint32_t>(j * (p_.cells_x + 1) + i); }
  // Share of a line of nodes in the cells beside it: 1/2 at a border, which has cells on one side only.
  static double Share(int index, int cells) { return index == 0 || index == cells ? 0.5 : 1.0; }

  void AddNodes() {
    for (int j = 0; j <= p_.cells_y; ++j) {
      for (int i = 0; i <= p_.cells_x; ++i) {
        grid_.p_W.push_back(p_.X_WS * glm::dvec3((static_cast<double>(i) / p_.cells_x - 0.5) * p_.size_x_m,
                                                 (static_cast<double>(j) / p_.cells_y - 0.5) * p_.size_y_m, 0.0));
        grid_.mass_kg.push_back(p_.density_kg_per_m2 * a_ * b_ * Share(i, p_.cells_x) * Share(j, p_.cells_y));
      }
    }
  }

  // Springs of a cell a x b [m] whose strain energy is that of a sheet with membrane stiffness Y [N/m] and Poisson's
  // ratio 1/3, the only ratio that a lattice of central forces can have. A spring k of length l along n adds k (n'En)^2
  // l^2 / (2 a b) to the energy density. Diagonals d = sqrt(a^2 + b^2):
  //   C12 = C66 = 2 kd a b / d^2,  C11 = (kx a^2 + 2 kd a^4/d^2) / (a b),  C22 likewise,
  // to be 3Y/8, 9Y/8 and 9Y/8 (plane stress, nu = 1/3: C11 = Y / (1 - nu^2), C12 = nu C11, C66 = (C11 - C12) / 2):
  //   kd = 3Y d^2 / (16 a b),  kx = 9Y b / (8 a) - 3Y a / (8 b),  ky = 9Y a / (8 b) - 3Y b / (8 a).
  // kx > 0 and ky > 0 require 1/sqrt(3) < a/b < sqrt(3), hence the check for 0.6 to 1.7. An inner edge gets half of kx
  // from each of its two cells, a border edge from one.
  void AddSprings() {
    const double Y = p_.stretch_stiffness_N_per_m;
    const double d = std::hypot(a_, b_);
    const double kd = 3.0 * Y * d * d / (16.0 * a_ * b_);
    const double kx = 9.0 * Y * b_ / (8.0 * a_) - 3.0 * Y * a_ / (8.0 * b_);
    const double ky = 9.0 * Y * a_ / (8.0 * b_) - 3.0 * Y * b_ / (8.0 * a_);
    // Consecutive springs share no node, so that the processor can compute several at once.
    for (int first = 0; first < 2; ++first) {
      for (int j = 0; j <= p_.cells_y; ++j) {
        for (int i = first; i < p_.cells_x; i += 2) {
          grid_.springs.push_back({Node(i, j), Node(i + 1, j), a_, kx * Share(j, p_.cells_y)});
        }
      }
    }
    for (int j = 0; j < p_.cells_y; ++j) {
      for (int i = 0; i <= p_.cells_x; ++i) {
        grid_.springs.push_back({Node(i, j), Node(i, j + 1), b_, ky * Share(i, p_.cells_x)});
      }
    }
    for (int j = 0; j < p_.cells_y; ++j) {
      for (int i = 0; i < p_.cells_x; ++i) grid_.springs.push_back({Node(i, j), Node(i + 1, j + 1), d, kd});
      for (int i = 0; i < p_.cells_x; ++i) grid_.springs.push_back({Node(i + 1, j), Node(i, j + 1), d, kd});
    }
  }

  // Plate energy D/2 (kxx^2 + kyy^2 + 2 kxy^2) per area, D [Nm], with the curvatures [1/m] as second differences of
  // positions: on an unstretched sheet their length is the curvature, and a rotation of the whole leaves the energy
  // unchanged.
  //   kxx = (x_(i-1) - 2 x_i + x_(i+1)) / a^2 over an area a b;  kxy = (x00 - x10 - x01 + x11) / (a b) over a cell.
  void AddBends() {
    const double D = p_.bending_stiffness_Nm;
    if (D == 0.0) return;
    const auto add_line = [&](std::uint32_t u, std::uint32_t v, std::uint32_t w, double stiffness) {
      grid_.bends.push_back({{u, v, w, w}, {1.0, -2.0, 1.0, 0.0}, stiffness});
    };
    for (int j = 0; j <= p_.cells_y; ++j) {
      for (int i = 0; i <= p_.cells_x; ++i) {
        if (i > 0 && i < p_.cells_x) {
          add_line(Node(i - 1, j), Node(i, j), Node(i + 1, j), D * b_ / (a_ * a_ * a_) * Share(j, p_.cells_y));
        }
        if (j > 0 && j < p_.cells_y) {
          add_line(Node(i, j - 1), Node(i, j), Node(i, j + 1), D * a_ / (b_ * b_ * b_) * Share(i, p_.cells_x));
        }
        if (i < p_.cells_x && j < p_.cells_y) {
          grid_.bends.push_back({{Node(i, j), Node(i + 1, j), Node(i, j + 1), Node(i + 1, j + 1)},
                                 {1.0, -1.0, -1.0, 1.0},
                                 2.0 * D / (a_ * b_)});
        }
      }
    }
  }

  // Bound on the frequencies of bending, which are omega^2 = eigenvalues of M^-1 K: by Gershgorin's theorem none
  // exceeds the largest sum of magnitudes of a row, max_i sum_j |K_ij| / m_i.
  void BoundFrequency() {
    std::vector<double> sums(grid_.p_W.size(), 0.0);
    for (const ClothGrid::Bend& bend : grid_.bends) {
      double total = 0.0;
      for (const double weight : bend.weight) total += std::abs(weight);
      for (std::size_t k = 0; k < bend.node.size(); ++k) {
        sums[bend.node[k]] += bend.stiffness_N_per_m * std::abs(bend.weight[k]) * total;
      }
    }
    double largest = 0.0;
    for (std::size_t i = 0; i < sums.size(); ++i) largest = std::max(largest, sums[i] / grid_.mass_kg[i]);
    grid_.highest_bending_rad_per_s = std::sqrt(largest);
  }

  const ClothParams& p_;
  double a_;
  double b_;
  ClothGrid grid_;
};

}  // namespace

core::Result<ClothGrid> BuildClothGrid(const ClothParams& params) {
  if (const auto checked = Check(params); !checked) return core::Fail(checked.error().code, checked.error().detail);
  return Builder(params).Build();
}

}  // namespace physics
