#include "vps/field/surface_errors.hpp"

#include <algorithm>
#include <cmath>

#include "vps/field/brick_means.hpp"

namespace vps {
namespace {

constexpr double kLongestPart = 4.0;  // voxels

// Errors of places average out in a contact, all of one sign do not.
constexpr double kOneWay = 6.0;

// Evenly over the unit square, folded into a triangle (Roberts' sequence of two dimensions).
glm::dvec2 PlaceInTriangle(std::uint32_t i) {
  const glm::dvec2 place = glm::fract(glm::dvec2(0.7548776662466927, 0.5698402909980532) * (i + 0.5));
  return place.x + place.y > 1.0 ? 1.0 - place : place;
}

}  // namespace

std::vector<std::uint8_t> SurfaceErrors(const TriangleField& triangles, const DistanceField& field) {
  BrickMeans means(field);
  BrickMeans squares(field);
  std::uint32_t count = 0;
  for (std::uint32_t t = 0; t < triangles.num_triangles() && !triangles.is_sheet(); ++t) {
    const auto corners = triangles.corners(t);
    ForParts(corners[0], corners[1], corners[2], kLongestPart, [&](const auto& a, const auto& b, const auto& c) {
      const glm::dvec2 place = PlaceInTriangle(count++);
      const glm::dvec3 p = a + place.x * (b - a) + place.y * (c - a);
      const double area = 0.5 * glm::length(glm::cross(b - a, c - a));
      const auto error = static_cast<double>(SampleField(field, glm::vec3(p)).distance);
      means.Add(p, area, area * error);
      squares.Add(p, area, area * error * error);
    });
  }
  std::vector<std::uint8_t> errors(squares.size());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double error = std::max(std::sqrt(squares.mean(i)), kOneWay * std::abs(means.mean(i)));
    const double steps = error / static_cast<double>(kErrorStep);
    errors[i] = static_cast<std::uint8_t>(std::min(255.0, std::round(steps)));
  }
  return errors;
}

float SurfaceErrorAt(const DistanceField& field, const glm::vec3& p) {
  float steps = 0.0f;
  BrickMeans::ForBricksAround(p, glm::ivec3(field.nx, field.ny, field.nz) >> 3, [&](std::size_t brick, float share) {
    steps += share * static_cast<float>(field.errors[brick]);
  });
  return steps * kErrorStep;
}

}  // namespace vps
