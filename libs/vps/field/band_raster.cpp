#include "vps/field/band_raster.hpp"

#include <algorithm>
#include <cmath>

namespace vps {
namespace {

BandBricks::Brick& BrickAt(BandBricks* band, int x, int y, int z) {
  std::uint32_t& slot = band->index[(static_cast<std::size_t>(z) * band->by + y) * band->bx + x];
  if (slot == BandBricks::kNone) {
    slot = static_cast<std::uint32_t>(band->bricks.size());
    auto brick = std::make_unique<BandBricks::Brick>();
    brick->cell = {x, y, z};
    std::fill(std::begin(brick->squared_distance), std::end(brick->squared_distance), 1e30f);
    std::fill(std::begin(brick->triangle), std::end(brick->triangle), BandBricks::kNone);
    band->bricks.push_back(std::move(brick));
  }
  return *band->bricks[slot];
}

// Range of u that the triangle covers where v lies within `band` of `row`.
bool RowRange(const std::array<glm::dvec3, 3>& corners, int u, int v, double row, double band, double* first,
              double* last) {
  *first = 1e300;
  *last = -1e300;
  const double low = row - band;
  const double high = row + band;
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3& a = corners[k];
    const glm::dvec3& b = corners[(k + 1) % 3];
    double s0 = 0.0;
    double s1 = 1.0;
    const double dv = b[v] - a[v];
    if (dv == 0.0) {
      if (a[v] < low || a[v] > high) continue;
    } else {
      const double sl = (low - a[v]) / dv;
      const double sh = (high - a[v]) / dv;
      s0 = std::max(s0, std::min(sl, sh));
      s1 = std::min(s1, std::max(sl, sh));
      if (s0 > s1) continue;
    }
    for (const double s : {s0, s1}) {
      const double at = a[u] + s * (b[u] - a[u]);
      *first = std::min(*first, at);
      *last = std::max(*last, at);
    }
  }
  return *first <= *last;
}

}  // namespace

std::uint32_t BandBricks::TriangleAt(const glm::ivec3& voxel) const {
  if (voxel.x < 0 || voxel.y < 0 || voxel.z < 0) return kNone;
  const glm::ivec3 b = voxel >> 3;
  if (b.x >= bx || b.y >= by || b.z >= bz) return kNone;
  const std::uint32_t slot = index[(static_cast<std::size_t>(b.z) * by + b.y) * bx + b.x];
  if (slot == kNone) return kNone;
  return bricks[slot]->triangle[(voxel.z & 7) << 6 | (voxel.y & 7) << 3 | (voxel.x & 7)];
}

BandBricks RasterBand(const TriangleField& triangles, const glm::ivec3& grid_bricks, double band) {
  BandBricks out;
  out.bx = grid_bricks.x;
  out.by = grid_bricks.y;
  out.bz = grid_bricks.z;
  out.index.assign(static_cast<std::size_t>(out.bx) * out.by * out.bz, BandBricks::kNone);
  const glm::ivec3 last_voxel = grid_bricks * DistanceField::kBrick - 1;
  const auto reach = static_cast<float>(band * band);
  for (std::uint32_t t = 0; t < triangles.num_triangles(); ++t) {
    const auto& corners = triangles.corners(t);
    const glm::dvec3 lower = glm::min(corners[0], glm::min(corners[1], corners[2])) - band;
    const glm::dvec3 upper = glm::max(corners[0], glm::max(corners[1], corners[2])) + band;
    glm::dvec3 n = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double length = glm::length(n);
    n = length > 0.0 ? n / length : glm::dvec3(0.0, 0.0, 1.0);
    int w = 2;
    for (int k = 0; k < 2; ++k) {
      if (std::abs(n[k]) > std::abs(n[w])) w = k;
    }
    const int u = (w + 1) % 3;
    const int v = (w + 2) % 3;
    const double offset = glm::dot(n, corners[0]);
    // Sample i stands at i + 1/2.
    const auto first_sample = [&](double at, int axis) {
      return std::clamp(static_cast<int>(std::ceil(at - 0.5)), 0, last_voxel[axis]);
    };
    const auto last_sample = [&](double at, int axis) {
      return std::clamp(static_cast<int>(std::floor(at - 0.5)), 0, last_voxel[axis]);
    };
    glm::ivec3 i;
    glm::dvec3 p;
    for (i[v] = first_sample(lower[v], v); i[v] <= last_sample(upper[v], v); ++i[v]) {
      p[v] = i[v] + 0.5;
      double u0 = 0.0;
      double u1 = 0.0;
      if (!RowRange(corners, u, v, p[v], band, &u0, &u1)) continue;
      const int u_end = last_sample(u1 + band, u);
      for (i[u] = first_sample(u0 - band, u); i[u] <= u_end; ++i[u]) {
        p[u] = i[u] + 0.5;
        double w0 = lower[w];
        double w1 = upper[w];
        if (length > 0.0) {  // |n . p - offset| <= band
          const double middle = (offset - n[u] * p[u] - n[v] * p[v]) / n[w];
          const double half = band / std::abs(n[w]);
          w0 = std::max(w0, middle - half);
          w1 = std::min(w1, middle + half);
          if (w0 > w1) continue;
        }
        const int w_end = last_sample(w1, w);
        for (i[w] = first_sample(w0, w); i[w] <= w_end; ++i[w]) {
          p[w] = i[w] + 0.5;
          const auto squared = static_cast<float>(triangles.Closest(t, p).squared_distance);
          if (squared > reach) continue;
          BandBricks::Brick& brick = BrickAt(&out, i.x >> 3, i.y >> 3, i.z >> 3);
          const int at = (i.z & 7) << 6 | (i.y & 7) << 3 | (i.x & 7);
          if (squared < brick.squared_distance[at]) {
            brick.squared_distance[at] = squared;
            brick.triangle[at] = t;
          }
        }
      }
    }
  }
  return out;
}

}  // namespace vps
