#include "vps/mesh/orient_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "vps/mesh/edge_table.hpp"
#include "vps/mesh/winding_number.hpp"

namespace vps {
namespace {

// Nesting is resolved for meshes of at most so many parts; in larger ones every part counts as outermost. Not derived:
// bounds the time, which grows with the square of the number of parts.
constexpr std::size_t kMaxNestedParts = 256;
// The sign of a volume smaller than this times area^1.5 is not trusted (a ball has 0.094). Not derived.
constexpr double kFlatness = 1e-4;

struct Part {
  std::vector<std::uint32_t> triangles;
  double area_m2 = 0.0;
  double volume_m3 = 0.0;
  Box box;
};

void Turn(std::uint32_t triangle, TriangleMesh* mesh) {
  std::swap(mesh->triangles[triangle][1], mesh->triangles[triangle][2]);
}

Part Measure(const TriangleMesh& mesh, std::vector<std::uint32_t> triangles) {
  Part part;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  part.box = {glm::dvec3(kFar), glm::dvec3(-kFar)};
  for (const std::uint32_t t : triangles) {
    for (const glm::dvec3& p : mesh.corners(t)) {
      part.box.lower = glm::min(part.box.lower, p);
      part.box.upper = glm::max(part.box.upper, p);
    }
  }
  const glm::dvec3 centre = 0.5 * (part.box.lower + part.box.upper);
  for (const std::uint32_t t : triangles) {
    const auto [a, b, c] = mesh.corners(t);
    part.area_m2 += 0.5 * glm::length(glm::cross(b - a, c - a));
    part.volume_m3 += glm::dot(a - centre, glm::cross(b - centre, c - centre)) / 6.0;
  }
  part.triangles = std::move(triangles);
  return part;
}

// The smallest part around each, or -1.
std::vector<int> Containers(const TriangleMesh& mesh, const std::vector<Part>& parts) {
  std::vector<int> container(parts.size(), -1);
  if (parts.size() > kMaxNestedParts) return container;
  for (std::size_t inner = 0; inner < parts.size(); ++inner) {
    const Box& box = parts[inner].box;
    for (std::size_t outer = 0; outer < parts.size(); ++outer) {
      const Box& around = parts[outer].box;
      const bool is_inside_box = outer != inner && glm::all(glm::lessThan(around.lower, box.lower)) &&
                                 glm::all(glm::lessThan(box.upper, around.upper));
      if (!is_inside_box) continue;
      const glm::dvec3 p = mesh.corners(parts[inner].triangles[0])[0];
      double winding = 0.0;
      for (const std::uint32_t t : parts[outer].triangles) winding += WindingOfTriangle(mesh.corners(t), p);
      if (std::abs(winding) < 0.5) continue;
      const bool is_smaller =
          container[inner] < 0 || std::abs(parts[outer].volume_m3) < std::abs(parts[container[inner]].volume_m3);
      if (is_smaller) container[inner] = static_cast<int>(outer);
    }
  }
  return container;
}

// Makes the neighbours of one part agree; returns its triangles.
class Spreader {
 public:
  explicit Spreader(TriangleMesh* mesh) : mesh_(mesh), was_turned_(mesh->triangles.size()), part_(was_turned_.size()) {
    neighbours_.resize(mesh->triangles.size());
    const std::vector<EdgeUse> edges = SortedEdges(*mesh);
    for (std::size_t i = 0; i < edges.size();) {
      const std::size_t end = EndOfEdge(edges, i);
      if (end - i == 2) {
        const bool agrees = edges[i].is_forward != edges[i + 1].is_forward;
        neighbours_[edges[i].triangle][edges[i].corner] = {edges[i + 1].triangle, agrees};
        neighbours_[edges[i + 1].triangle][edges[i + 1].corner] = {edges[i].triangle, agrees};
      }
      i = end;
    }
  }

  std::vector<std::uint32_t> Spread(std::uint32_t seed, std::vector<std::uint32_t>* conflicting) {
    std::vector<std::uint32_t> members{seed};
    part_[seed] = 1;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::uint32_t t = members[i];
      for (const Neighbour& other : neighbours_[t]) {
        if (other.triangle == kNone) continue;
        const bool turn = was_turned_[t] != static_cast<std::uint8_t>(other.agrees ? 0 : 1);
        if (part_[other.triangle] == 0) {
          part_[other.triangle] = 1;
          was_turned_[other.triangle] = turn ? 1 : 0;
          members.push_back(other.triangle);
        } else if ((was_turned_[other.triangle] != 0) != turn) {
          conflicting->push_back(t);
        }
      }
    }
    // The side that most of the area shows stays.
    double kept = 0.0;
    for (const std::uint32_t t : members) {
      const auto [a, b, c] = mesh_->corners(t);
      kept += (was_turned_[t] != 0 ? -1.0 : 1.0) * glm::length(glm::cross(b - a, c - a));
    }
    for (const std::uint32_t t : members) {
      if (kept < 0.0) was_turned_[t] ^= 1;
      if (was_turned_[t] != 0) Turn(t, mesh_);
    }
    std::sort(members.begin(), members.end());
    return members;
  }

  [[nodiscard]] bool is_known(std::uint32_t triangle) const { return part_[triangle] != 0; }
  [[nodiscard]] bool was_turned(std::uint32_t triangle) const { return was_turned_[triangle] != 0; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffU;
  struct Neighbour {
    std::uint32_t triangle = kNone;
    bool agrees = true;
  };
  TriangleMesh* mesh_;
  std::vector<std::uint8_t> was_turned_;
  std::vector<std::uint8_t> part_;
  std::vector<std::array<Neighbour, 3>> neighbours_;
};

}  // namespace

Orientation OrientParts(TriangleMesh* mesh) {
  Orientation result;
  Spreader spreader(mesh);
  std::vector<Part> parts;
  for (std::uint32_t t = 0; t < mesh->triangles.size(); ++t) {
    if (!spreader.is_known(t)) parts.push_back(Measure(*mesh, spreader.Spread(t, &result.conflicting)));
  }
  result.num_parts = parts.size();
  const std::vector<int> container = Containers(*mesh, parts);
  std::vector<std::uint8_t> is_turned_whole(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    std::size_t outermost = p;
    for (std::size_t depth = 0; container[outermost] >= 0 && depth < parts.size(); ++depth) {
      outermost = static_cast<std::size_t>(container[outermost]);
    }
    const Part& outer = parts[outermost];
    is_turned_whole[p] = outer.volume_m3 < -kFlatness * std::pow(outer.area_m2, 1.5) ? 1 : 0;
  }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    bool is_any_turned = false;
    for (const std::uint32_t t : parts[p].triangles) {
      if (is_turned_whole[p] != 0) Turn(t, mesh);
      if (spreader.was_turned(t) == (is_turned_whole[p] != 0)) continue;
      result.turned.push_back(t);
      is_any_turned = true;
    }
    result.num_parts_turned += is_any_turned ? 1 : 0;
  }
  std::sort(result.turned.begin(), result.turned.end());
  std::sort(result.conflicting.begin(), result.conflicting.end());
  result.conflicting.erase(std::unique(result.conflicting.begin(), result.conflicting.end()), result.conflicting.end());
  return result;
}

}  // namespace vps
