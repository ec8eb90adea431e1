#include "vps/query/tree_query.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "vps/query/pair_transform.hpp"

#ifdef __SSE__
#include <xmmintrin.h>
#endif

namespace vps {
namespace {

// Four floats side by side: the compiler's vector type, plain SSE on every x86-64, NEON on ARM.
using Float4 = float __attribute__((vector_size(16)));
using Int4 = std::int32_t __attribute__((vector_size(16)));

inline Float4 Load4(const float* p) {
  Float4 v;
  std::memcpy(&v, p, sizeof(v));
  return v;
}
inline Float4 Splat(float v) {
  return Float4{v, v, v, v};
}

// Bit k set: lane k is true.
inline unsigned Bits(Int4 mask) {
#ifdef __SSE__
  return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#else
  return (mask[0] & 1U) | (mask[1] & 2U) | (mask[2] & 4U) | (mask[3] & 8U);
#endif
}

struct Field {
  const std::int8_t* layers;
  std::int32_t nx, ny;
  float x_end, y_end, z_end;  // grid size in voxels
  float border;               // padding: the surface lies within [border, end - border]
};

inline Int4 IsInside(const Field& f, Float4 x, Float4 y, Float4 z) {
  return (x >= Splat(0.0f)) & (y >= Splat(0.0f)) & (z >= Splat(0.0f)) & (x < Splat(f.x_end)) & (y < Splat(f.y_end)) &
         (z < Splat(f.z_end));
}

inline Int4 ToCell(Float4 v, Int4 inside) {
  // Lanes outside the grid read voxel 0, and their result is not used.
  const Int4 kept = reinterpret_cast<Int4>(v) & inside;
  return __builtin_convertvector(reinterpret_cast<Float4>(kept), Int4);
}

inline float DistanceToBox(const Field& f, float x, float y, float z) {
  const float dx = std::max({f.border - x, 0.0f, x - (f.x_end - f.border)});
  const float dy = std::max({f.border - y, 0.0f, y - (f.y_end - f.border)});
  const float dz = std::max({f.border - z, 0.0f, z - (f.z_end - f.border)});
  return std::sqrt(dx * dx + dy * dy + dz * dz);
}

Field MakeField(const Voxmap& v) {
  return {v.layers.data(),
          v.nx,
          v.ny,
          static_cast<float>(v.nx),
          static_cast<float>(v.ny),
          static_cast<float>(v.nz),
          static_cast<float>(v.border_layers)};
}

// Voxels to subtract from a layer number for a lower bound of the distance to the nearest hit: m + 1 + sqrt(3), derived
// in the header. The last 0.01 covers the float rounding of the transformed centre.
float SphereSlack(double margin_m, double voxel_size_m) {
  return static_cast<float>(OutermostLayer(margin_m, voxel_size_m)) + 1.0f + 1.7321f + 0.01f;
}

// Voxels by which a sphere's centre can move before the sphere can hold a hit; negative: it can already.
inline float SphereFreeDistance(const Field& f, const PairTransform& T, const Cluster& c, float slack) {
  const glm::vec3 centre = T.ToVoxels({c.centre_m[0], c.centre_m[1], c.centre_m[2]});
  const float x = centre.x;
  const float y = centre.y;
  const float z = centre.z;
  float clearance = 0.0f;
  if (x >= 0.0f && y >= 0.0f && z >= 0.0f && x < f.x_end && y < f.y_end && z < f.z_end) {
    const std::size_t cell =
        (static_cast<std::size_t>(static_cast<int>(z)) * f.ny + static_cast<int>(y)) * f.nx + static_cast<int>(x);
    clearance = -static_cast<float>(f.layers[cell]);
  } else {
    clearance = DistanceToBox(f, x, y, z) * 0.999999f;
  }
  return clearance - slack - c.radius_m / T.voxel_size_m;
}

}  // namespace

QueryResult QueryTree(const PointTree& sampled, const Voxmap& field, const core::Pose& X_GS, double margin_m,
                      QueryScratch* scratch) {
  QueryResult result;
  if (sampled.clusters.empty()) {
    result.free_distance_m = 1e9;
    return result;
  }
  const PairTransform T(X_GS, field);
  const Field f = MakeField(field);
  const float slack = SphereSlack(margin_m, field.voxel_size_m);
  const float inverse_voxel = 1.0f / T.voxel_size_m;
  const auto margin = static_cast<float>(margin_m);
  const auto outermost = static_cast<float>(OutermostLayer(margin_m, field.voxel_size_m));
  const Cluster* const clusters = sampled.clusters.data();
  std::uint32_t* const queue = scratch->queue.data();
  PointHit* const hits = scratch->hits.data();

  const Float4 m00 = Splat(T.m[0][0]), m01 = Splat(T.m[0][1]), m02 = Splat(T.m[0][2]), t0 = Splat(T.t[0]);
  const Float4 m10 = Splat(T.m[1][0]), m11 = Splat(T.m[1][1]), m12 = Splat(T.m[1][2]), t1 = Splat(T.t[1]);
  const Float4 m20 = Splat(T.m[2][0]), m21 = Splat(T.m[2][1]), m22 = Splat(T.m[2][2]), t2 = Splat(T.t[2]);

  result.spheres_tested = 1;
  float free_voxels = SphereFreeDistance(f, T, clusters[0], slack);
  if (free_voxels > 0.0f) {
    result.free_distance_m = static_cast<double>(free_voxels) * field.voxel_size_m;
    return result;
  }
  free_voxels = 1e9f;
  std::size_t head = 0;
  std::size_t tail = 0;
  queue[tail++] = 0;
  while (head < tail) {
    const Cluster& cluster = clusters[queue[head++]];
    const std::uint32_t count = cluster.num_children;
    const std::uint32_t first = cluster.first_child;
    if (!cluster.is_leaf) {
      // Four spheres; a cluster with fewer children repeats its first.
      const Cluster* const c0 = clusters + first;
      const Cluster* const c1 = count > 1 ? c0 + 1 : c0;
      const Cluster* const c2 = count > 2 ? c0 + 2 : c0;
      const Cluster* const c3 = count > 3 ? c0 + 3 : c0;
      const Float4 cx = {c0->centre_m[0], c1->centre_m[0], c2->centre_m[0], c3->centre_m[0]};
      const Float4 cy = {c0->centre_m[1], c1->centre_m[1], c2->centre_m[1], c3->centre_m[1]};
      const Float4 cz = {c0->centre_m[2], c1->centre_m[2], c2->centre_m[2], c3->centre_m[2]};
      const Float4 radius = {c0->radius_m, c1->radius_m, c2->radius_m, c3->radius_m};
      const Float4 x = m00 * cx + m01 * cy + m02 * cz + t0;
      const Float4 y = m10 * cx + m11 * cy + m12 * cz + t1;
      const Float4 z = m20 * cx + m21 * cy + m22 * cz + t2;
      const Int4 inside = IsInside(f, x, y, z);
      const Int4 cell = (ToCell(z, inside) * f.ny + ToCell(y, inside)) * f.nx + ToCell(x, inside);
      const Int4 layer = {f.layers[cell[0]], f.layers[cell[1]], f.layers[cell[2]], f.layers[cell[3]]};
      Float4 clearance = -__builtin_convertvector(layer, Float4);
      const unsigned present = (1U << count) - 1U;
      for (unsigned outside = ~Bits(inside) & present; outside != 0; outside &= outside - 1U) {
        const int k = std::countr_zero(outside);
        clearance[k] = DistanceToBox(f, x[k], y[k], z[k]) * 0.999999f;
      }
      const Float4 free = clearance - Splat(slack) - radius * Splat(inverse_voxel);
      const unsigned is_near = Bits(free <= Splat(0.0f));
      for (std::uint32_t k = 0; k < count; ++k) {
        queue[tail] = first + k;
        tail += is_near >> k & 1U;
      }
      if (free_voxels > 0.0f) {  // after the first hit it is 0 for good
        for (unsigned apart = ~is_near & present; apart != 0; apart &= apart - 1U) {
          free_voxels = std::min(free_voxels, free[std::countr_zero(apart)]);
        }
      }
      result.spheres_tested += count;
      continue;
    }
    const Float4 qx = Load4(sampled.x.data() + first);
    const Float4 qy = Load4(sampled.y.data() + first);
    const Float4 qz = Load4(sampled.z.data() + first);
    const Float4 x = m00 * qx + m01 * qy + m02 * qz + t0;
    const Float4 y = m10 * qx + m11 * qy + m12 * qz + t1;
    const Float4 z = m20 * qx + m21 * qy + m22 * qz + t2;
    const Int4 inside = IsInside(f, x, y, z);
    const Int4 ix = ToCell(x, inside);
    const Int4 iy = ToCell(y, inside);
    const Int4 iz = ToCell(z, inside);
    const Int4 cell = (iz * f.ny + iy) * f.nx + ix;
    const Int4 layer = {f.layers[cell[0]], f.layers[cell[1]], f.layers[cell[2]], f.layers[cell[3]]};
    const Float4 v = __builtin_convertvector(layer, Float4);
    result.points_tested += count;
    const unsigned present = (1U << count) - 1U;
    const unsigned candidates = Bits(inside & (v >= Splat(-outermost))) & present;
    if (candidates == 0) {
      if (free_voxels <= 0.0f) continue;
      const unsigned in_grid = Bits(inside);
      for (std::uint32_t k = 0; k < count; ++k) {
        const float clearance = (in_grid >> k & 1U) != 0 ? -v[k] : DistanceToBox(f, x[k], y[k], z[k]) * 0.999999f;
        free_voxels = std::min(free_voxels, clearance - slack);
      }
      continue;
    }
    const Float4 nx = Load4(sampled.nx.data() + first);
    const Float4 ny = Load4(sampled.ny.data() + first);
    const Float4 nz = Load4(sampled.nz.data() + first);
    const Float4 half = Splat(0.5f);
    // V(P) = v s + n . e, e from the point to the centre of its voxel [VR-OOS, Eq. 1].
    Float4 local = (Splat(T.r[0][0]) * nx + Splat(T.r[0][1]) * ny + Splat(T.r[0][2]) * nz) *
                   (__builtin_convertvector(ix, Float4) + half - x);
    local += (Splat(T.r[1][0]) * nx + Splat(T.r[1][1]) * ny + Splat(T.r[1][2]) * nz) *
             (__builtin_convertvector(iy, Float4) + half - y);
    local += (Splat(T.r[2][0]) * nx + Splat(T.r[2][1]) * ny + Splat(T.r[2][2]) * nz) *
             (__builtin_convertvector(iz, Float4) + half - z);
    const Float4 penetration = (v + local) * Splat(T.voxel_size_m);
    unsigned is_hit = Bits(penetration >= Splat(-margin)) & candidates;
    result.num_colliding += static_cast<std::uint32_t>(std::popcount(Bits(penetration >= Splat(0.0f)) & is_hit));
    for (; is_hit != 0; is_hit &= is_hit - 1U) {
      const auto k = static_cast<std::uint32_t>(std::countr_zero(is_hit));
      hits[result.num_hits++] = {first + k, penetration[k]};
      result.max_penetration_m = std::max(result.max_penetration_m, penetration[k]);
    }
    free_voxels = 0.0f;
  }
  if (result.num_hits == 0) {
    result.free_distance_m = std::max(0.0, static_cast<double>(free_voxels) * field.voxel_size_m);
  }
  return result;
}

}  // namespace vps
