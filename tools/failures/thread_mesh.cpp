#include "tools/failures/thread_mesh.hpp"

#include <cmath>
#include <numbers>

namespace failures {
namespace {

constexpr int kSegments = 96;        // of a turn
constexpr int kRows_per_pitch = 16;  // the profile's corners lie on rows: a crest of 1/8, flanks of 5/16

// Radius of the surface at a share of the pitch from the middle of the crest.
double Radius_m(const Thread& thread, double share) {
  const double from_crest = std::abs(share - std::round(share));
  const double depth_m = 0.625 * 0.5 * std::numbers::sqrt3 * thread.pitch_m;
  return thread.major_m - depth_m * std::min(1.0, std::max(0.0, (from_crest - 1.0 / 16.0) / (5.0 / 16.0)));
}

// Rows of points about z from the lower to the upper end.
std::vector<glm::dvec3> Surface(const Thread& thread, double gap_m, double length_m, int rows) {
  std::vector<glm::dvec3> points;
  for (int row = 0; row <= rows; ++row) {
    const double z = length_m * (static_cast<double>(row) / rows - 0.5);
    for (int i = 0; i < kSegments; ++i) {
      const double turn = static_cast<double>(i) / kSegments;
      const double r = Radius_m(thread, z / thread.pitch_m - turn) + gap_m;
      const double angle = 2.0 * std::numbers::pi * turn;
      points.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
    }
  }
  return points;
}

int RowsOf(const Thread& thread, double length_m) {
  return static_cast<int>(std::lround(kRows_per_pitch * length_m / thread.pitch_m));
}

// Quads between two rings of points, facing away from the axis if `below` is under `above`.
void Join(std::uint32_t below, std::uint32_t above, vps::TriangleMesh* mesh) {
  for (std::uint32_t i = 0; i < kSegments; ++i) {
    const std::uint32_t j = (i + 1) % kSegments;
    mesh->triangles.push_back({below + i, below + j, above + j});
    mesh->triangles.push_back({below + i, above + j, above + i});
  }
}

}  // namespace

vps::TriangleMesh MakeBolt(const Thread& thread, double length_m) {
  const int rows = RowsOf(thread, length_m);
  vps::TriangleMesh mesh;
  mesh.vertices = Surface(thread, 0.0, length_m, rows);
  for (int row = 0; row < rows; ++row)
    Join(static_cast<std::uint32_t>(row * kSegments), static_cast<std::uint32_t>((row + 1) * kSegments), &mesh);
  const auto last = static_cast<std::uint32_t>(rows * kSegments);
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.0, 0.0, -0.5 * length_m);
  mesh.vertices.emplace_back(0.0, 0.0, 0.5 * length_m);
  for (std::uint32_t i = 0; i < kSegments; ++i) {
    const std::uint32_t j = (i + 1) % kSegments;
    mesh.triangles.push_back({middle, j, i});
    mesh.triangles.push_back({middle + 1, last + i, last + j});
  }
  return mesh;
}

vps::TriangleMesh MakeNut(const Thread& thread, double gap_m, double outer_m, double length_m) {
  const int rows = RowsOf(thread, length_m);
  vps::TriangleMesh mesh;
  mesh.vertices = Surface(thread, gap_m, length_m, rows);
  for (int row = 0; row < rows; ++row)  // upside down: towards the axis
    Join(static_cast<std::uint32_t>((row + 1) * kSegments), static_cast<std::uint32_t>(row * kSegments), &mesh);
  const auto last = static_cast<std::uint32_t>(rows * kSegments);
  const auto outside = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const double z : {-0.5 * length_m, 0.5 * length_m}) {
    for (int i = 0; i < kSegments; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kSegments;
      mesh.vertices.emplace_back(outer_m * std::cos(angle), outer_m * std::sin(angle), z);
    }
  }
  Join(outside, outside + kSegments, &mesh);
  Join(0, outside, &mesh);
  Join(outside + kSegments, last, &mesh);
  return mesh;
}

}  // namespace failures
