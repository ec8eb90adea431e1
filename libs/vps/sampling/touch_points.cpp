#include "vps/sampling/touch_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "vps/force/direction_bins.hpp"

namespace vps {
namespace {

// Of mean normals: patches and faces that differ by less are one plane. 0.25 degrees.
constexpr float kFlat = 1.0f - 1e-5f;

constexpr float kSharp_rad = static_cast<float>(kSharpAngle_deg * std::numbers::pi / 180.0);

constexpr float kSamePlace = 1e-4f;  // of the length of a side

using Key = std::tuple<float, float, float>;
Key KeyOf(const glm::vec3& p) {
  return {p.x, p.y, p.z};
}

// A side of a piece, and the piece across it.
struct Side {
  glm::vec3 from, to;
  std::array<glm::vec3, 2> outward;
  std::array<glm::vec3, 2> apex;
  int count = 0;
};
struct Corner {
  glm::vec3 p;
  glm::vec3 first_outward;
  glm::vec3 sum{0.0f};               // of outward normals, by angle
  std::vector<glm::vec3> outward{};  // of the faces around it
  bool is_flat = true;
};

float AngleBetween(const glm::vec3& a, const glm::vec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

class Surface {
 public:
  explicit Surface(const SurfaceTree& tree) {
    for (const SurfacePiece& piece : tree.triangles) Add(piece);
    MatchRest();
  }

  // Between neighbours that differ by no more than kSharpAngle_deg.
  [[nodiscard]] double Turn_rad() const {
    float most_rad = 0.0f;
    for (const auto& [key, side] : sides_) {
      if (side.count != 2) continue;
      const float turn_rad = AngleBetween(side.outward[0], side.outward[1]);
      if (turn_rad <= kSharp_rad) most_rad = std::max(most_rad, turn_rad);
    }
    return static_cast<double>(most_rad);
  }

  void AddPlaces(double spacing_m, std::vector<glm::dvec3>* points, std::vector<TouchPlace>* places) const {
    for (const auto& [key, side] : sides_) {
      if (side.count != 2) continue;
      const float cosine = glm::dot(side.outward[0], side.outward[1]);
      if (cosine > kFlat || !IsConvex(side)) continue;
      const float length = glm::length(side.to - side.from);
      const int parts = std::max(1, static_cast<int>(std::ceil(static_cast<double>(length) / spacing_m)));
      TouchPlace place{TouchPlace::Kind::kEdge, 0, {}, (side.to - side.from) / length, 0.5f * length / float(parts)};
      place.inward = -glm::normalize(side.outward[0] + side.outward[1]);
      place.cone_rad = AngleBetween(-place.inward, side.outward[0]);
      for (int i = 0; i < parts; ++i) {
        points->emplace_back(side.from +
                             (static_cast<float>(i) + 0.5f) / static_cast<float>(parts) * (side.to - side.from));
        places->push_back(place);
      }
    }
    for (const auto& [key, corner] : corners_) {
      if (corner.is_flat || !(glm::length(corner.sum) > 1e-3f)) continue;
      points->emplace_back(corner.p);
      const glm::vec3 mean = glm::normalize(corner.sum);
      float cone_rad = 0.0f;
      for (const glm::vec3& outward : corner.outward) cone_rad = std::max(cone_rad, AngleBetween(mean, outward));
      places->push_back({TouchPlace::Kind::kCorner, 0, -mean, {}, 0.0f, cone_rad});
    }
  }

 private:
  void Add(const SurfacePiece& piece) {
    const glm::vec3 n = glm::cross(piece.corners[1] - piece.corners[0], piece.corners[2] - piece.corners[0]);
    const glm::vec3 outward = n / glm::length(n);
    for (int k = 0; k < 3; ++k) {
      const glm::vec3& p = piece.corners[k];
      const glm::vec3& next = piece.corners[(k + 1) % 3];
      const glm::vec3& last = piece.corners[(k + 2) % 3];
      Corner& corner = corners_.try_emplace(KeyOf(p), Corner{p, outward}).first->second;
      corner.outward.push_back(outward);
      corner.is_flat = corner.is_flat && glm::dot(corner.first_outward, outward) > kFlat;
      const float cosine = glm::dot(glm::normalize(next - p), glm::normalize(last - p));
      corner.sum += std::acos(std::clamp(cosine, -1.0f, 1.0f)) * outward;
      const bool is_forward = KeyOf(p) < KeyOf(next);
      const auto key = is_forward ? std::pair(KeyOf(p), KeyOf(next)) : std::pair(KeyOf(next), KeyOf(p));
      Side& side = sides_.try_emplace(key, Side{p, next, {}, {}, 0}).first->second;
      if (side.count < 2) {
        side.outward[static_cast<std::size_t>(side.count)] = outward;
        side.apex[static_cast<std::size_t>(side.count)] = last;
      }
      ++side.count;
    }
  }
  // Thin triangles are cut across each for itself, so that pieces on either side of an edge may have other corners: the
  // piece across is one whose side lies along this one.
  void MatchRest() {
    float longest = 0.0f;
    std::vector<Side*> rest;
    for (auto& [key, side] : sides_) {
      if (side.count != 1) continue;
      rest.push_back(&side);
      longest = std::max(longest, glm::length(side.to - side.from));
    }
    const auto cell_of = [&](const glm::vec3& p) { return glm::ivec3(glm::floor(p / longest)); };
    std::map<std::tuple<int, int, int>, std::vector<const Side*>> cells;
    for (const Side* side : rest) {
      const glm::ivec3 cell = cell_of(0.5f * (side->from + side->to));
      cells[{cell.x, cell.y, cell.z}].push_back(side);
    }
    for (Side* side : rest) {
      const glm::vec3 middle = 0.5f * (side->from + side->to);
      const glm::ivec3 cell = cell_of(middle);
      for (int i = 0; i < 27; ++i) {
        const auto at = cells.find({cell.x + i / 9 - 1, cell.y + i / 3 % 3 - 1, cell.z + i % 3 - 1});
        if (at == cells.end()) continue;
        for (const Side* other : at->second) {
          if (other == side || !Holds(*other, middle) || IsAlong(*side, *other)) continue;
          if (KeyOf(side->outward[0]) <= KeyOf(other->outward[0])) continue;  // one of the two is enough
          side->outward[1] = other->outward[0];
          side->apex[1] = other->apex[0];
          side->count = 2;
        }
      }
    }
  }
  static bool Holds(const Side& side, const glm::vec3& p) {
    const glm::vec3 way = side.to - side.from;
    const float t = glm::dot(p - side.from, way) / glm::dot(way, way);
    return t >= 0.0f && t <= 1.0f && glm::length(p - side.from - t * way) < kSamePlace * glm::length(way);
  }
  // Sides of neighbouring pieces run in opposite directions.
  static bool IsAlong(const Side& a, const Side& b) { return glm::dot(a.to - a.from, b.to - b.from) > 0.0f; }
  static bool IsConvex(const Side& side) { return glm::dot(side.outward[0], side.apex[1] - side.from) < 0.0f; }

  std::map<std::pair<Key, Key>, Side> sides_;
  std::map<Key, Corner> corners_;
};

void GroupPlaces(TouchPoints* touch) {
  touch->group_begin = {0};
  for (std::size_t first = 0; first < touch->places.size(); first += kBlock) {
    const auto begin = static_cast<std::ptrdiff_t>(touch->groups.size());
    for (std::size_t k = 0; k < kBlock && first + k < touch->places.size(); ++k) {
      const TouchPlace& place = touch->places[first + k];
      auto group = std::find_if(touch->groups.begin() + begin, touch->groups.end(),
                                [&](const TouchGroup& g) { return g.kind == place.kind && g.bin == place.bin; });
      if (group == touch->groups.end()) {
        touch->groups.push_back({place.kind, place.bin, 0});
        group = touch->groups.end() - 1;
      }
      group->lanes = static_cast<std::uint16_t>(group->lanes | 1U << k);
    }
    touch->group_begin.push_back(static_cast<std::uint32_t>(touch->groups.size()));
  }
}

}  // namespace

TouchPoints FindTouchPoints(const SampleTree& samples, const SurfaceTree& tree) {
  SurfaceSamples surface;
  std::vector<TouchPlace> places;
  const double spacing_m = std::sqrt(samples.area_m2 / std::max(samples.num_points, 1U));
  for (std::size_t i = 0; i < samples.num_points; ++i) {
    const PointBlock& block = samples.points[i / kBlock];
    const std::size_t k = i % kBlock;
    const glm::vec3 inward(block.nx[k], block.ny[k], block.nz[k]);
    const float length = glm::length(inward);
    if (!(length > kFlat)) continue;
    surface.points_m.emplace_back(block.x[k], block.y[k], block.z[k]);
    surface.areas_m2.push_back(static_cast<double>(block.area_m2[k]));
    places.push_back({TouchPlace::Kind::kFace, 0, inward / length, glm::vec3(0.0f), std::sqrt(block.area_m2[k]), 0.0f});
  }
  // Penalty integrals are of the faces; what they do not cover is shared among the others.
  const std::size_t num_faces = surface.areas_m2.size();
  double rest_m2 = samples.area_m2;
  for (const double area_m2 : surface.areas_m2) rest_m2 -= area_m2;
  const Surface faces(tree);
  faces.AddPlaces(spacing_m, &surface.points_m, &places);
  const std::size_t num_others = surface.points_m.size() - num_faces;
  const double share_m2 = std::max(rest_m2, 1e-6 * samples.area_m2) / static_cast<double>(std::max(num_others, 1UL));
  surface.areas_m2.resize(surface.points_m.size(), share_m2);
  for (const TouchPlace& place : places) surface.inward_normals.emplace_back(place.inward);
  TouchPoints touch;
  touch.tree = BuildSampleTree(surface);
  touch.tree.area_m2 = samples.area_m2;
  touch.surface = &tree;
  touch.spacing_m = spacing_m;
  touch.turn_rad = faces.Turn_rad();
  for (const std::uint32_t i : OrderInRuns(surface.points_m)) {  // as the tree's points
    TouchPlace& place = touch.places.emplace_back(places[i]);
    place.bin = static_cast<std::uint8_t>(DirectionBin(place.inward));
    touch.most_reach_m = std::max(touch.most_reach_m, static_cast<double>(place.reach_m));
  }
  GroupPlaces(&touch);
  return touch;
}

}  // namespace vps
