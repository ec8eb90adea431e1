#include "space/stars/star_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace space {
namespace {

constexpr int kCellsPerEdge = 24;  // of a cube's face; 3 to 5 degrees wide
constexpr std::size_t kNumCells = 6 * kCellsPerEdge * kCellsPerEdge;
constexpr double kBvStep = 0.02;  // of the catalogue's file

// Cell of the cube around the eye.
std::size_t CellOf(const glm::dvec3& d) {
  const glm::dvec3 a = glm::abs(d);
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  const int face = 2 * axis + (d[axis] < 0.0 ? 1 : 0);
  const auto place = [&](int k) {
    const double p = 0.5 * (d[(axis + k) % 3] / a[axis] + 1.0) * kCellsPerEdge;
    return std::clamp(static_cast<int>(p), 0, kCellsPerEdge - 1);
  };
  return static_cast<std::size_t>((face * kCellsPerEdge + place(1)) * kCellsPerEdge + place(2));
}

}  // namespace

StarField::StarField(std::span<const Star> stars) {
  std::array<glm::dvec3, 256> colors;
  for (std::size_t i = 0; i < colors.size(); ++i) colors[i] = ColorOf(kBvStep * static_cast<double>(i) - 0.5);
  std::vector<std::uint32_t> cell_of(stars.size());
  std::vector<std::size_t> first(kNumCells + 1, 0);
  for (std::size_t i = 0; i < stars.size(); ++i) {
    cell_of[i] = static_cast<std::uint32_t>(CellOf(stars[i].direction_C));
    ++first[cell_of[i] + 1];
  }
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (auto* part : {&x_, &y_, &z_}) part->resize(stars.size());
  illuminance_lx_.resize(stars.size());
  for (std::size_t i = 0; i < stars.size(); ++i) {
    const Star& star = stars[i];
    const std::size_t at = next[cell_of[i]]++;
    x_[at] = static_cast<float>(star.direction_C.x);
    y_[at] = static_cast<float>(star.direction_C.y);
    z_[at] = static_cast<float>(star.direction_C.z);
    const auto color = static_cast<std::size_t>(std::clamp((star.color_bv + 0.5) / kBvStep + 0.5, 0.0, 255.0));
    illuminance_lx_[at] = glm::vec3(Illuminance_lx(star.magnitude) * colors[color]);
  }
  for (std::size_t c = 0; c < kNumCells; ++c) {
    if (first[c] == first[c + 1]) continue;
    Cell cell{{}, 0.0f, first[c], first[c + 1]};
    for (std::size_t i = cell.first; i < cell.last; ++i) cell.centre_C += glm::vec3(x_[i], y_[i], z_[i]);
    cell.centre_C = glm::normalize(cell.centre_C);
    float least = 1.0f;
    for (std::size_t i = cell.first; i < cell.last; ++i) {
      least = std::min(least, glm::dot(cell.centre_C, glm::vec3(x_[i], y_[i], z_[i])));
    }
    cell.radius_rad = std::acos(least) + 1e-3f;
    cells_.push_back(cell);
  }
}

std::size_t StarField::AddTo(const StarCamera& camera, std::span<glm::vec4> image) const {
  const glm::mat3 R_CV(glm::transpose(camera.R_VC));
  const glm::vec3 right = R_CV[0], up = R_CV[1], ahead = -R_CV[2];
  const auto f = static_cast<float>(camera.focal_px), f_up = static_cast<float>(camera.focal_ratio * camera.focal_px);
  const glm::vec2 axis_px(camera.axis_px);
  const float half_width = 0.5f * static_cast<float>(camera.width);
  const float half_height = 0.5f * static_cast<float>(camera.height);
  const float view_rad = std::atan(
      std::hypot((half_width + std::abs(axis_px.x) + 1.0f) / f, (half_height + std::abs(axis_px.y) + 1.0f) / f_up));
  const glm::vec2 middle_px = glm::vec2(half_width - 0.5f, half_height - 0.5f) + axis_px;
  std::size_t num_drawn = 0;
  for (const Cell& cell : cells_) {
    const float reach_rad = std::min(view_rad + cell.radius_rad, 3.14159265f);
    if (glm::dot(cell.centre_C, ahead) < std::cos(reach_rad)) continue;
    for (std::size_t i = cell.first; i < cell.last; ++i) {
      const float depth = ahead.x * x_[i] + ahead.y * y_[i] + ahead.z * z_[i];
      if (depth < 1e-3f) continue;
      const float across = f / depth, upwards = f_up / depth;
      // From the centre of the lowest pixel on the left.
      const float px = middle_px.x + across * (right.x * x_[i] + right.y * y_[i] + right.z * z_[i]);
      const float py = middle_px.y + upwards * (up.x * x_[i] + up.y * y_[i] + up.z * z_[i]);
      if (!(px > -1.0f && py > -1.0f && px < 2.0f * half_width && py < 2.0f * half_height)) continue;
      ++num_drawn;
      // A pixel is 1 / f wide and 1 / f_up high at the distance 1 along the axis; it is 1 / depth away and tilted by an
      // angle of that cosine: depth^3 / (f f_up) [sr].
      const glm::vec4 luminance(illuminance_lx_[i] * (f * f_up / (depth * depth * depth)), 0.0f);
      const int column = static_cast<int>(px + 1.0f) - 1, row = static_cast<int>(py + 1.0f) - 1;
      const float wx = px - static_cast<float>(column), wy = py - static_cast<float>(row);
      const float weights[4] = {(1.0f - wx) * (1.0f - wy), wx * (1.0f - wy), (1.0f - wx) * wy, wx * wy};
      for (int k = 0; k < 4; ++k) {
        const int c = column + (k & 1), r = row + (k >> 1);
        if (c < 0 || r < 0 || c >= camera.width || r >= camera.height) continue;
        image[static_cast<std::size_t>(r) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(c)] +=
            weights[k] * luminance;
      }
    }
  }
  return num_drawn;
}

}  // namespace space
