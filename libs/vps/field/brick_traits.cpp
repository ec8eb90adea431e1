#include "vps/field/brick_traits.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vps {
namespace {

// Longest side of the parts that triangles are cut into, voxels: half a brick, the grid of the weights.
constexpr double kLongestPart = 0.5 * DistanceField::kBrick;

// Edges that turn more are sharp, not curved: creases handle them. The angle of kSharpAngle_deg; with
// them the flanks of a thread were 6 % off (decision 10).
constexpr double kSharp_rad = 25.0 / 180.0 * std::numbers::pi;

// Weight of the mean error against the root mean square: errors of both signs average out in a contact, errors of one
// sign do not. Chosen by 64 poses of the benchmark pairs (decision 16).
constexpr float kOneWay = 6.0f;

// Calls visit(brick, its share) for the eight whose middles are around p, in voxels. Shares add up to 1.
template <typename Visit>
void ForBricksAround(const glm::vec3& p, const glm::ivec3& n, const Visit& visit) {
  const glm::vec3 q = p / static_cast<float>(DistanceField::kBrick) - 0.5f;
  const glm::ivec3 corner(glm::floor(q));
  const glm::vec3 f = q - glm::vec3(corner);
  for (int k = 0; k < 8; ++k) {
    const glm::ivec3 step(k & 1, k >> 1 & 1, k >> 2);
    const glm::ivec3 at = glm::clamp(corner + step, glm::ivec3(0), n - 1);
    const glm::vec3 share = glm::mix(1.0f - f, f, glm::vec3(step));
    visit(static_cast<std::size_t>((at.z * n.y + at.y) * n.x + at.x), share.x * share.y * share.z);
  }
}

glm::ivec3 NumBricks(const DistanceField& field) {
  return glm::ivec3(field.nx, field.ny, field.nz) / DistanceField::kBrick;
}

// Of a piece of surface, or of all around a brick: area A, sum of edge length times turn of the normal, and integrals
// of the error e and of e^2. Then  curvature = turn / A,  rms error = sqrt(square / A),  mean error = error / A.
struct Traits {
  float area = 0.0f, turn = 0.0f, error = 0.0f, square = 0.0f;
};

// Evenly over the unit square, folded into a triangle (Roberts' sequence of two dimensions).
glm::dvec2 PlaceInTriangle(std::uint32_t i) {
  const glm::dvec2 place = glm::fract(glm::dvec2(0.7548776662466927, 0.5698402909980532) * (i + 0.5));
  return place.x + place.y > 1.0 ? 1.0 - place : place;
}

class TraitSums {
 public:
  explicit TraitSums(const DistanceField& field)
      : field_(field),
        n_(NumBricks(field)),
        sums_(static_cast<std::size_t>(n_.x) * static_cast<std::size_t>(n_.y) * static_cast<std::size_t>(n_.z)) {}

  // Estimates its error at one place of each part.
  void AddTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double sides[3] = {glm::length(b - a), glm::length(c - b), glm::length(a - c)};
    const int k = static_cast<int>(std::max_element(sides, sides + 3) - sides);
    if (sides[k] <= kLongestPart) {
      const glm::dvec2 place = PlaceInTriangle(num_parts_++);
      const auto area = static_cast<float>(0.5 * glm::length(glm::cross(b - a, c - a)));
      const float error = SampleField(field_, glm::vec3(a + place.x * (b - a) + place.y * (c - a))).distance;
      Add((a + b + c) / 3.0, {area, 0.0f, area * error, area * error * error});
      return;
    }
    const glm::dvec3 around[5] = {a, b, c, a, b};
    const glm::dvec3 middle = 0.5 * (around[k] + around[k + 1]);
    AddTriangle(around[k], middle, around[k + 2]);
    AddTriangle(middle, around[k + 1], around[k + 2]);
  }

  void AddEdge(const glm::dvec3& a, const glm::dvec3& b, double turn) {
    const double length = glm::length(b - a);
    const int parts = static_cast<int>(length / kLongestPart) + 1;
    const auto turn_of_part = static_cast<float>(turn * length / parts);
    for (int i = 0; i < parts; ++i) Add(glm::mix(a, b, (i + 0.5) / parts), {.turn = turn_of_part});
  }

  [[nodiscard]] std::vector<std::int16_t> Curvatures() const {
    std::vector<std::int16_t> curvatures((sums_.size() + 1) / 2 * 2, 0);  // kernels read two at once
    constexpr float kMost = 32767.0f;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      if (!(sums_[i].area > 0.0f)) continue;
      const float steps = sums_[i].turn / sums_[i].area / kCurvatureStep;
      curvatures[i] = static_cast<std::int16_t>(std::lround(std::clamp(steps, -kMost, kMost)));
    }
    return curvatures;
  }

  [[nodiscard]] std::vector<std::uint8_t> Errors() const {
    std::vector<std::uint8_t> errors(sums_.size(), 0);
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const Traits& sum = sums_[i];
      if (!(sum.area > 0.0f)) continue;
      const float error = std::max(std::sqrt(sum.square / sum.area), kOneWay * std::abs(sum.error / sum.area));
      errors[i] = static_cast<std::uint8_t>(std::min(255L, std::lround(error / kErrorStep)));
    }
    return errors;
  }

 private:
  void Add(const glm::dvec3& p, const Traits& traits) {
    ForBricksAround(glm::vec3(p), n_, [&](std::size_t brick, float share) {
      Traits& sum = sums_[brick];
      sum.area += share * traits.area;
      sum.turn += share * traits.turn;
      sum.error += share * traits.error;
      sum.square += share * traits.square;
    });
  }

  const DistanceField& field_;
  glm::ivec3 n_;
  std::uint32_t num_parts_ = 0;
  std::vector<Traits> sums_;
};

}  // namespace

void ComputeBrickTraits(const TriangleField& triangles, DistanceField* field) {
  TraitSums sums(*field);
  for (std::uint32_t t = 0; t < triangles.num_triangles(); ++t) {
    const auto corners = triangles.corners(t);
    const glm::dvec3& n = triangles.normal(t);
    if (n == glm::dvec3(0.0)) continue;
    sums.AddTriangle(corners[0], corners[1], corners[2]);
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3& a = corners[static_cast<std::size_t>(k)];
      const glm::dvec3& b = corners[static_cast<std::size_t>((k + 1) % 3)];
      // Of an edge that bulges the neighbour's normal leans out of this face. Each side adds half of the turn.
      const glm::dvec3 other = triangles.neighbour_normal(t, k);
      if (glm::dot(other, other) < 0.5) continue;  // the surface's border
      const double out = glm::dot(other, glm::normalize(glm::cross(b - a, n)));
      const double turn = std::atan2(out, glm::dot(other, n));
      if (std::abs(turn) < kSharp_rad) sums.AddEdge(a, b, 0.5 * turn);
    }
  }
  field->curvatures = sums.Curvatures();
  field->errors = sums.Errors();
}

float SurfaceErrorAt(const DistanceField& field, const glm::vec3& p) {
  float steps = 0.0f;
  ForBricksAround(p, NumBricks(field),
                  [&](std::size_t brick, float share) { steps += share * static_cast<float>(field.errors[brick]); });
  return steps * kErrorStep;
}

}  // namespace vps
