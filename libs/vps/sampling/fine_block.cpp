#include "vps/sampling/fine_block.hpp"

#include <algorithm>
#include <cmath>

namespace vps {
namespace {

struct Group {
  glm::dvec3 place{0.0}, normal{0.0};  // times area
  double area_m2 = 0.0;
  double cover_m = 0.0;
};

// Halves the cell along its longest side until there is one part for each point or one panel in each part.
void Divide(const std::vector<SurfacePanel>& panels, std::span<std::uint32_t> cell, std::uint32_t num_parts,
            std::vector<Group>* groups) {
  if (cell.empty()) return;
  if (num_parts == 1 || cell.size() == 1) {
    Group group;
    for (const std::uint32_t i : cell) {
      group.area_m2 += panels[i].area_m2;
      group.place += panels[i].area_m2 * panels[i].centroid_m;
      group.normal += panels[i].area_m2 * panels[i].normal;
    }
    const glm::dvec3 middle = group.place / group.area_m2;
    for (const std::uint32_t i : cell) {
      group.cover_m = std::max(group.cover_m, glm::length(panels[i].centroid_m - middle) + panels[i].radius_m);
    }
    groups->push_back(group);
    return;
  }
  glm::dvec3 lower(1e300);
  glm::dvec3 upper(-1e300);
  for (const std::uint32_t i : cell) {
    lower = glm::min(lower, panels[i].centroid_m);
    upper = glm::max(upper, panels[i].centroid_m);
  }
  const glm::dvec3 extent = upper - lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  const std::size_t half = cell.size() / 2;
  std::nth_element(cell.begin(), cell.begin() + static_cast<std::ptrdiff_t>(half), cell.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double at_a = panels[a].centroid_m[axis];
                     const double at_b = panels[b].centroid_m[axis];
                     return at_a != at_b ? at_a < at_b : a < b;
                   });
  Divide(panels, cell.first(half), num_parts / 2, groups);
  Divide(panels, cell.subspan(half), num_parts / 2, groups);
}

template <class T>
void UnpackRow(const T* __restrict steps, float step, float from, float* __restrict to) {
  for (std::uint32_t k = 0; k < kBlock; ++k) to[k] = from + step * static_cast<float>(steps[k]);
}

}  // namespace

FineBlock MakeFineBlock(const std::vector<SurfacePanel>& panels, std::span<std::uint32_t> cell, const glm::dvec3& p,
                        const glm::dvec3& inward_normal) {
  std::vector<Group> groups;
  groups.reserve(kBlock);
  Divide(panels, cell, kBlock, &groups);
  FineBlock fine{};
  double area_m2 = 0.0;
  double farthest_m = 0.0;
  double steepest = 0.0;
  for (Group& group : groups) {
    area_m2 += group.area_m2;
    group.place = group.place / group.area_m2 - p;
    group.normal = -group.normal / group.area_m2 - inward_normal;
    for (int i = 0; i < 3; ++i) {
      farthest_m = std::max(farthest_m, std::abs(group.place[i]));
      steepest = std::max(steepest, std::abs(group.normal[i]));
    }
    fine.cover_m = std::max(fine.cover_m, static_cast<float>(group.cover_m));
    fine.reach_m = std::max(fine.reach_m, static_cast<float>(glm::length(group.place) + group.cover_m));
  }
  fine.place_step_m = static_cast<float>(farthest_m / 32767.0);
  fine.normal_step = static_cast<float>(steepest / 127.0);
  const auto steps = [](double value, float step) {
    return step > 0.0f ? std::lround(value / static_cast<double>(step)) : 0L;
  };
  long left = static_cast<long>(kShares);
  double area_left_m2 = area_m2;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    const Group& group = groups[k];
    fine.x[k] = static_cast<std::int16_t>(std::clamp(steps(group.place.x, fine.place_step_m), -32767L, 32767L));
    fine.y[k] = static_cast<std::int16_t>(std::clamp(steps(group.place.y, fine.place_step_m), -32767L, 32767L));
    fine.z[k] = static_cast<std::int16_t>(std::clamp(steps(group.place.z, fine.place_step_m), -32767L, 32767L));
    fine.nx[k] = static_cast<std::int8_t>(std::clamp(steps(group.normal.x, fine.normal_step), -127L, 127L));
    fine.ny[k] = static_cast<std::int8_t>(std::clamp(steps(group.normal.y, fine.normal_step), -127L, 127L));
    fine.nz[k] = static_cast<std::int8_t>(std::clamp(steps(group.normal.z, fine.normal_step), -127L, 127L));
    // The next points get what rounding took from this one.
    const long share =
        k + 1 == groups.size() ? left : std::lround(static_cast<double>(left) * group.area_m2 / area_left_m2);
    fine.share[k] = static_cast<std::uint16_t>(share);
    left -= share;
    area_left_m2 -= group.area_m2;
  }
  // A pad for the rounding of places.
  fine.reach_m = fine.reach_m * (1.0f + 1e-6f) + 2.0f * fine.place_step_m;
  fine.cover_m = fine.cover_m * (1.0f + 1e-6f) + 2.0f * fine.place_step_m;
  return fine;
}

void Unpack(const FineBlock& fine, const PointBlock& block, std::uint32_t at, float weight, PointBlock* points) {
  const float area_step_m2 = block.area_m2[at] * weight / kShares;
  UnpackRow(fine.x, fine.place_step_m, block.x[at], points->x);
  UnpackRow(fine.y, fine.place_step_m, block.y[at], points->y);
  UnpackRow(fine.z, fine.place_step_m, block.z[at], points->z);
  UnpackRow(fine.nx, fine.normal_step, block.nx[at], points->nx);
  UnpackRow(fine.ny, fine.normal_step, block.ny[at], points->ny);
  UnpackRow(fine.nz, fine.normal_step, block.nz[at], points->nz);
  UnpackRow(fine.share, area_step_m2, 0.0f, points->area_m2);
}

}  // namespace vps
