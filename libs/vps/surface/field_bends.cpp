#include "vps/surface/field_bends.hpp"

#include <algorithm>
#include <cmath>

#include "vps/surface/node_integral.hpp"

namespace vps {
namespace {

constexpr float kKept = 0.25f;  // of the mean, in `most`
constexpr int kMostLevels = 8;

using Matrix = std::array<float, 6>;

Matrix SecondDifferences(const DistanceField& field, const glm::vec3& p, float h) {
  const auto at = [&](float x, float y, float z) { return SampleField(field, p + h * glm::vec3(x, y, z)).distance; };
  const float twice = 2.0f * at(0, 0, 0);
  const float per = 1.0f / (h * h);
  return {per * (at(1, 0, 0) + at(-1, 0, 0) - twice),
          per * (at(0, 1, 0) + at(0, -1, 0) - twice),
          per * (at(0, 0, 1) + at(0, 0, -1) - twice),
          0.25f * per * (at(1, 1, 0) + at(-1, -1, 0) - at(1, -1, 0) - at(-1, 1, 0)),
          0.25f * per * (at(1, 0, 1) + at(-1, 0, -1) - at(1, 0, -1) - at(-1, 0, 1)),
          0.25f * per * (at(0, 1, 1) + at(0, -1, -1) - at(0, 1, -1) - at(0, -1, 1))};
}

// H^2 / |H|: positive semidefinite, with H's axes, and |H| where H has one axis, as at an edge or on a cylinder.
Matrix Magnitude(const Matrix& H) {
  const glm::vec3 columns[3] = {{H[0], H[3], H[4]}, {H[3], H[1], H[5]}, {H[4], H[5], H[2]}};
  const float norm =
      std::sqrt(H[0] * H[0] + H[1] * H[1] + H[2] * H[2] + 2.0f * (H[3] * H[3] + H[4] * H[4] + H[5] * H[5]));
  if (!(norm > 0.0f)) return {};
  const auto dot = [&](int i, int j) { return glm::dot(columns[i], columns[j]) / norm; };
  return {dot(0, 0), dot(1, 1), dot(2, 2), dot(0, 1), dot(0, 2), dot(1, 2)};
}

// Raises M where S exceeds it most: M += c u u^T with u the largest axis of S - M and c its value, found by power
// iteration from the largest diagonal element; twice, since S may exceed M along two axes.
void Raise(const Matrix& S, Matrix* M) {
  for (int repeat = 0; repeat < 2; ++repeat) {
    Matrix D;
    for (std::size_t i = 0; i < 6; ++i) D[i] = S[i] - (*M)[i];
    int axis = D[1] > D[0] ? 1 : 0;
    if (D[2] > D[static_cast<std::size_t>(axis)]) axis = 2;
    if (!(D[static_cast<std::size_t>(axis)] > 0.0f)) return;
    glm::vec3 u(0.0f);
    u[axis] = 1.0f;
    for (int step = 0; step < 3; ++step) {
      const glm::vec3 next = Times(D, u);
      const float length = glm::length(next);
      if (!(length > 0.0f)) return;
      u = next / length;
    }
    const float c = glm::dot(u, Times(D, u));
    if (!(c > 0.0f)) return;
    const Matrix uu = {u.x * u.x, u.y * u.y, u.z * u.z, u.x * u.y, u.x * u.z, u.y * u.z};
    for (std::size_t i = 0; i < 6; ++i) (*M)[i] += c * uu[i];
  }
}

// Calls visit(cell's number, place) for every place of the grid with this spacing that is up to h from the surface.
template <class Visit>
void ForPlaces(const DistanceField& field, const glm::ivec3& n, int shift, const Visit& visit) {
  const int spacing = std::max(1, 1 << shift >> 2);
  const float reach = static_cast<float>(1 << shift) + 1.0f;
  const float half = 0.5f * static_cast<float>(spacing);
  for (int z = 0; z < field.nz; z += spacing) {
    for (int y = 0; y < field.ny; y += spacing) {
      for (int x = 0; x < field.nx; x += spacing) {
        const glm::vec3 p(static_cast<float>(x) + half, static_cast<float>(y) + half, static_cast<float>(z) + half);
        if (std::abs(SampleField(field, p).distance) > reach) continue;
        const glm::ivec3 c(x >> shift, y >> shift, z >> shift);
        visit((static_cast<std::size_t>(c.z) * n.y + c.y) * n.x + c.x, p);
      }
    }
  }
}

}  // namespace

FieldBends::FieldBends(const DistanceField& field) {
  const int longest = std::max({field.nx, field.ny, field.nz});
  for (int shift = 0; shift < kMostLevels && (1 << shift) < longest; ++shift) {
    Level level;
    const int edge = 1 << shift;
    level.n = (glm::ivec3(field.nx, field.ny, field.nz) + (edge - 1)) / edge;
    Fill(field, shift, &level);
    levels_.push_back(std::move(level));
  }
}

void FieldBends::Fill(const DistanceField& field, int shift, Level* level) const {
  level->numbers.resize(static_cast<std::size_t>(level->n.x) * level->n.y * level->n.z);
  std::vector<std::uint32_t> counts;  // of the places in each of level->cells
  const float h = static_cast<float>(1 << shift);
  ForPlaces(field, level->n, shift, [&](std::size_t i, const glm::vec3& p) {
    std::uint32_t& number = level->numbers[i];
    if (number == 0) {
      level->cells.emplace_back();
      counts.push_back(0);
      number = static_cast<std::uint32_t>(level->cells.size());
    }
    const Matrix H = SecondDifferences(field, p, h);
    for (std::size_t k = 0; k < 6; ++k) level->cells[number - 1].mean[k] += H[k];
    ++counts[number - 1];
  });
  for (std::size_t i = 0; i < counts.size(); ++i) {
    for (float& value : level->cells[i].mean) value /= static_cast<float>(counts[i]);
  }
  ForPlaces(field, level->n, shift, [&](std::size_t i, const glm::vec3& p) {
    Bend& cell = level->cells[level->numbers[i] - 1];
    Matrix H = SecondDifferences(field, p, h);
    for (std::size_t k = 0; k < 6; ++k) H[k] -= (1.0f - kKept) * cell.mean[k];
    Raise(Magnitude(H), &cell.most);
  });
}

const Bend* FieldBends::At(const glm::vec3& p, float reach) const {
  std::size_t shift = 0;
  while (shift < levels_.size() && static_cast<float>(1 << shift) < reach) ++shift;
  if (shift == levels_.size()) return nullptr;
  const Level& level = levels_[shift];
  const glm::vec3 scaled = p / static_cast<float>(1 << shift);
  const glm::ivec3 c = glm::clamp(glm::ivec3(glm::floor(scaled)), glm::ivec3(0), level.n - 1);
  const std::uint32_t number = level.numbers[(static_cast<std::size_t>(c.z) * level.n.y + c.y) * level.n.x + c.x];
  return number == 0 ? nullptr : &level.cells[number - 1];
}

}  // namespace vps
