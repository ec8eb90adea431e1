#include "vps/asset/list_structures.hpp"

#include <cmath>

namespace vps {

std::vector<SurfacePoint> PointsOf(const SampleTree& tree) {
  std::vector<SurfacePoint> points;
  for (const PointBlock& block : tree.points) {
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      if (block.area_m2[k] <= 0.0f) continue;  // a filler
      points.push_back({glm::dvec3(block.x[k], block.y[k], block.z[k]),
                        -glm::dvec3(block.nx[k], block.ny[k], block.nz[k]), block.area_m2[k]});
    }
  }
  return points;
}

std::vector<SurfacePoint> PointsOf(const PointTree& tree) {
  std::vector<SurfacePoint> points;
  for (std::uint32_t i = 0; i < tree.num_points; ++i) {
    points.push_back({glm::dvec3(tree.x[i], tree.y[i], tree.z[i]), -glm::dvec3(tree.nx[i], tree.ny[i], tree.nz[i])});
  }
  return points;
}

std::vector<std::vector<TreeSphere>> LevelsOf(const SampleTree& tree) {
  std::vector<std::vector<TreeSphere>> levels;
  for (std::uint32_t level = tree.num_levels; level-- > 0;) {
    const std::size_t begin = tree.level_begin[level];
    const std::size_t end = level + 1 < tree.num_levels ? tree.level_begin[level + 1] : tree.spheres.size();
    levels.emplace_back();
    for (std::size_t b = begin; b < end; ++b) {
      const SphereBlock& block = tree.spheres[b];
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        if (block.r[k] <= 0.0f) continue;  // a filler
        levels.back().push_back({glm::dvec3(block.x[k], block.y[k], block.z[k]), block.r[k]});
      }
    }
  }
  return levels;
}

std::vector<std::vector<TreeSphere>> LevelsOf(const PointTree& tree) {
  std::vector<std::vector<TreeSphere>> levels;
  std::vector<std::uint32_t> level{0};
  while (!level.empty() && !tree.clusters.empty()) {
    levels.emplace_back();
    std::vector<std::uint32_t> next;
    for (const std::uint32_t c : level) {
      const Cluster& cluster = tree.clusters[c];
      levels.back().push_back(
          {glm::dvec3(cluster.centre_m[0], cluster.centre_m[1], cluster.centre_m[2]), cluster.radius_m});
      if (cluster.is_leaf != 0) continue;
      for (std::uint32_t k = 0; k < cluster.num_children; ++k) next.push_back(cluster.first_child + k);
    }
    level = std::move(next);
  }
  return levels;
}

std::vector<glm::vec3> SurfaceVoxelsOf(const DistanceField& field) {
  std::vector<glm::vec3> centres_m;
  const auto voxel_m = static_cast<float>(field.voxel_size_m);
  const glm::vec3 origin_m(field.origin_m);
  const glm::ivec3 bricks = glm::ivec3(field.nx, field.ny, field.nz) / DistanceField::kBrick;
  for (std::size_t b = 0; b < field.bricks.size(); ++b) {
    if (field.bricks[b] == 0) continue;  // far from the surface
    const auto i = static_cast<int>(b);
    const glm::ivec3 first =
        DistanceField::kBrick * glm::ivec3(i % bricks.x, i / bricks.x % bricks.y, i / (bricks.x * bricks.y));
    for (int k = 0; k < static_cast<int>(DistanceField::kBrickWords); ++k) {
      const glm::vec3 centre = glm::vec3(first + glm::ivec3(k & 7, k >> 3 & 7, k >> 6)) + 0.5f;
      const FieldSample sample = SampleField(field, centre);
      const glm::vec3 g = glm::abs(sample.gradient);
      if (std::abs(sample.distance) <= 0.5f * (g.x + g.y + g.z)) centres_m.push_back(origin_m + voxel_m * centre);
    }
  }
  return centres_m;
}

std::vector<glm::vec3> SurfaceVoxelsOf(const Voxmap& map) {
  std::vector<glm::vec3> centres_m;
  const auto voxel_m = static_cast<float>(map.voxel_size_m);
  for (int z = 0; z < map.nz; ++z) {
    for (int y = 0; y < map.ny; ++y) {
      for (int x = 0; x < map.nx; ++x) {
        if (map.at(x, y, z) != 0) continue;
        centres_m.push_back(glm::vec3(map.origin_m) + voxel_m * (glm::vec3(x, y, z) + 0.5f));
      }
    }
  }
  return centres_m;
}

}  // namespace vps
