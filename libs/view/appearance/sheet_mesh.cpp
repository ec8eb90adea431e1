#include "view/appearance/sheet_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "view/appearance/lattice_noise.hpp"

namespace view {
namespace {

constexpr float kDent = 0.22f;  // largest tilt of the unit normal per direction; by eye, as all figures of the dents

// Value noise: interpolates between lattice points with 3 t^2 - 2 t^3, so that its slope is continuous.
float SmoothNoise(float u, float v, std::uint32_t layer) {
  const float fx = std::floor(u);
  const float fy = std::floor(v);
  const int x = static_cast<int>(fx);
  const int y = static_cast<int>(fy);
  const auto ease = [](float t) { return t * t * (3.0f - 2.0f * t); };
  const float s = ease(u - fx);
  const float t = ease(v - fy);
  return glm::mix(glm::mix(LatticeNoise(x, y, layer), LatticeNoise(x + 1, y, layer), s),
                  glm::mix(LatticeNoise(x, y + 1, layer), LatticeNoise(x + 1, y + 1, layer), s), t);
}

// Weights of the Catmull-Rom spline [Catmull and Rom 1974] for a point t in [0, 1] between the second and third of four
// nodes: ((-t^3 + 2 t^2 - t), (3 t^3 - 5 t^2 + 2), (-3 t^3 + 4 t^2 + t), (t^3 - t^2)) / 2.
std::array<float, 4> Weights(float t) {
  const float t2 = t * t;
  const float t3 = t2 * t;
  return {0.5f * (-t3 + 2.0f * t2 - t), 0.5f * (3.0f * t3 - 5.0f * t2 + 2.0f), 0.5f * (-3.0f * t3 + 4.0f * t2 + t),
          0.5f * (t3 - t2)};
}

class Surface {
 public:
  explicit Surface(const Sheet& sheet)
      : sheet_(sheet),
        columns_(static_cast<int>(sheet.num_columns)),
        rows_(static_cast<int>(sheet.p_W.size() / std::max(1u, sheet.num_columns))) {}

  [[nodiscard]] int columns() const { return columns_; }
  [[nodiscard]] int rows() const { return rows_; }

  // Point at (s, t) in [0, 1]^2 of cell (i, j).
  [[nodiscard]] glm::vec3 At(int i, int j, float s, float t) const {
    const std::array<float, 4> a = Weights(s);
    const std::array<float, 4> b = Weights(t);
    glm::vec3 sum(0.0f);
    for (int n = 0; n < 4; ++n) {
      glm::vec3 row(0.0f);
      for (int m = 0; m < 4; ++m) row += a[static_cast<std::size_t>(m)] * Node(i + m - 1, j + n - 1);
      sum += b[static_cast<std::size_t>(n)] * row;
    }
    return sum;
  }

 private:
  // Nodes beyond the border are extrapolated linearly.
  [[nodiscard]] glm::vec3 Node(int i, int j) const {
    if (i < 0) return 2.0f * Node(0, j) - Node(1, j);
    if (i >= columns_) return 2.0f * Node(columns_ - 1, j) - Node(columns_ - 2, j);
    if (j < 0) return 2.0f * Node(i, 0) - Node(i, 1);
    if (j >= rows_) return 2.0f * Node(i, rows_ - 1) - Node(i, rows_ - 2);
    return sheet_.p_W[static_cast<std::size_t>(j * columns_ + i)];
  }

  const Sheet& sheet_;
  int columns_;
  int rows_;
};

}  // namespace

vps::VisualPrimitive MakeSheetMesh(const Sheet& sheet) {
  vps::VisualPrimitive mesh;
  const Surface surface(sheet);
  if (surface.columns() < 2 || surface.rows() < 2) return mesh;
  const int width = (surface.columns() - 1) * kSheetRefinement + 1;
  const int height = (surface.rows() - 1) * kSheetRefinement + 1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int i = std::min(x / kSheetRefinement, surface.columns() - 2);
      const int j = std::min(y / kSheetRefinement, surface.rows() - 2);
      mesh.positions.push_back(surface.At(i, j, static_cast<float>(x - i * kSheetRefinement) / kSheetRefinement,
                                          static_cast<float>(y - j * kSheetRefinement) / kSheetRefinement));
    }
  }
  const auto at = [&](int x, int y) {
    return mesh.positions[static_cast<std::size_t>(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const glm::vec3 along = at(x + 1, y) - at(x - 1, y);
      const glm::vec3 across = at(x, y + 1) - at(x, y - 1);
      const glm::vec3 n = glm::cross(along, across);
      const float length = glm::length(n);
      glm::vec3 normal = length > 0.0f ? n / length : glm::vec3(0.0f, 0.0f, 1.0f);
      const auto u = static_cast<float>(x);
      const auto v = static_cast<float>(y);
      const float dent_x = SmoothNoise(0.31f * u, 0.31f * v, 1) + 0.7f * SmoothNoise(0.83f * u, 0.83f * v, 2);
      const float dent_y = SmoothNoise(0.31f * u, 0.31f * v, 3) + 0.7f * SmoothNoise(0.83f * u, 0.83f * v, 4);
      if (length > 0.0f) {
        normal = glm::normalize(normal +
                                kDent * (dent_x * along / glm::length(along) + dent_y * across / glm::length(across)));
      }
      mesh.normals.push_back(normal);
    }
  }
  for (int y = 0; y + 1 < height; ++y) {
    for (int x = 0; x + 1 < width; ++x) {
      const auto a = static_cast<std::uint32_t>(y * width + x);
      const auto up = a + static_cast<std::uint32_t>(width);
      for (const std::uint32_t index : {a, a + 1, up + 1, a, up + 1, up}) mesh.indices.push_back(index);
    }
  }
  return mesh;
}

}  // namespace view
