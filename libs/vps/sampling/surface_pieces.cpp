#include "vps/sampling/surface_pieces.hpp"

#include <cmath>

#include "vps/sampling/sliver.hpp"

namespace vps {
namespace {

float SquaredSide(const SurfacePiece& piece, int k) {
  const glm::vec3 side = piece.corners[(k + 1) % 3] - piece.corners[k];
  return glm::dot(side, side);
}

// The side from corner k to k + 1.
int LongestSide(const SurfacePiece& piece) {
  int k = SquaredSide(piece, 1) > SquaredSide(piece, 0) ? 1 : 0;
  if (SquaredSide(piece, 2) > SquaredSide(piece, k)) k = 2;
  return k;
}

glm::vec3 AreaVector(const SurfacePiece& piece) {
  return glm::cross(piece.corners[1] - piece.corners[0], piece.corners[2] - piece.corners[0]);
}

// Halves across the longest side. False: take() ended it.
template <class Take>
bool Cut(const SurfacePiece& piece, float longest_m, const Take& take) {
  const int k = LongestSide(piece);
  if (SquaredSide(piece, k) <= longest_m * longest_m) return take(piece);
  const glm::vec3& from = piece.corners[k];
  const glm::vec3& to = piece.corners[(k + 1) % 3];
  const glm::vec3& apex = piece.corners[(k + 2) % 3];
  const glm::vec3 middle = 0.5f * (from + to);
  return Cut({{from, middle, apex}}, longest_m, take) && Cut({{middle, to, apex}}, longest_m, take);
}

// A thin triangle is cut across first.
template <class Take>
bool CutTriangle(const std::array<glm::dvec3, 3>& corners, double longest_m, const Take& take) {
  const auto longest = static_cast<float>(longest_m);
  const auto cut = [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const SurfacePiece piece{{glm::vec3(a), glm::vec3(b), glm::vec3(c)}};
    return AreaVector(piece) == glm::vec3(0.0f) || Cut(piece, longest, take);
  };
  const Sliver sliver(corners);
  if (!sliver.is_thin()) return cut(corners[0], corners[1], corners[2]);
  constexpr double kSlice = 0.95;  // so that its diagonals are not too long
  const auto num_slices = static_cast<std::uint32_t>(std::ceil(sliver.length_m() / (kSlice * longest_m)));
  const double step_m = sliver.length_m() / num_slices;
  for (std::uint32_t i = 0; i < num_slices; ++i) {
    const double end_m = i + 1 < num_slices ? (i + 1) * step_m : sliver.length_m();
    const std::vector<glm::dvec3> slice = sliver.Slice(i * step_m, end_m);
    for (std::size_t k = 2; k < slice.size(); ++k) {
      if (!cut(slice[0], slice[k - 1], slice[k])) return false;
    }
  }
  return true;
}

template <class Take>
bool CutAll(const TriangleMesh& mesh, double longest_m, const Take& take) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!CutTriangle(mesh.corners(t), longest_m, take)) return false;
  }
  return true;
}

}  // namespace

std::size_t CountPieces(const TriangleMesh& mesh, double longest_m) {
  std::size_t count = 0;
  const bool is_all = CutAll(mesh, longest_m, [&](const SurfacePiece&) { return ++count <= kMostPieces; });
  return is_all ? count : 0;
}

SurfacePieces CutIntoPieces(const TriangleMesh& mesh, double longest_m) {
  std::vector<SurfacePiece> pieces;
  pieces.reserve(CountPieces(mesh, longest_m));
  if (pieces.capacity() == 0) return {};
  CutAll(mesh, longest_m, [&](const SurfacePiece& piece) {
    pieces.push_back(piece);
    return true;
  });
  std::vector<glm::dvec3> middles;
  for (const SurfacePiece& p : pieces) middles.emplace_back((p.corners[0] + p.corners[1] + p.corners[2]) / 3.0f);
  SurfacePieces out;
  std::vector<glm::vec3> corners;
  for (const std::uint32_t i : OrderInRuns(middles)) {
    out.pieces.push_back(pieces[i]);
    for (const glm::vec3& p : pieces[i].corners) corners.push_back(p);
  }
  static_cast<SphereTree&>(out) = BuildSphereTree(corners, 3, [&](std::size_t i) {
    const glm::vec3 n = AreaVector(out.pieces[i]);
    return n / glm::length(n);
  });
  return out;
}

}  // namespace vps
