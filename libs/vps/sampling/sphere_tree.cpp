#include "vps/sampling/sphere_tree.hpp"

#include <algorithm>
#include <numeric>

#include "vps/tree/build_tree.hpp"

namespace vps {
namespace {

// Halves along the longest side at multiples of the largest run that is smaller than the range.
void SortIntoRuns(const std::vector<glm::dvec3>& places, std::size_t begin, std::size_t end,
                  std::vector<std::uint32_t>* order) {
  const std::size_t count = end - begin;
  if (count <= kBlock) return;
  std::size_t run = kBlock;
  while (run * kBlock < count) run *= kBlock;
  glm::dvec3 lower(1e300);
  glm::dvec3 upper(-1e300);
  for (std::size_t i = begin; i < end; ++i) {
    lower = glm::min(lower, places[(*order)[i]]);
    upper = glm::max(upper, places[(*order)[i]]);
  }
  const glm::dvec3 extent = upper - lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  const std::size_t num_runs = (count + run - 1) / run;
  const std::size_t middle = begin + (num_runs / 2) * run;
  std::nth_element(order->begin() + static_cast<std::ptrdiff_t>(begin),
                   order->begin() + static_cast<std::ptrdiff_t>(middle),
                   order->begin() + static_cast<std::ptrdiff_t>(end), [&](std::uint32_t a, std::uint32_t b) {
                     return places[a][axis] != places[b][axis] ? places[a][axis] < places[b][axis] : a < b;
                   });
  SortIntoRuns(places, begin, middle, order);
  SortIntoRuns(places, middle, end, order);
}

SphereBlock FarBlock() {
  SphereBlock block{};
  std::fill(std::begin(block.x), std::end(block.x), SphereTree::kFarAway_m);
  return block;
}

// Padded by some roundings (2^-24) of floats of this size.
float Padded(float length, const glm::vec3& centre) {
  return length * (1.0f + 1e-6f) + 4e-7f * glm::length(centre);
}

// Around the places, about the centre, with the slab across n.
void PutSphere(std::span<const glm::vec3> places_m, const glm::vec3& centre_m, const glm::vec3& n, std::size_t lane,
               SphereBlock* block) {
  float radius = 0.0f;
  float h = 0.0f;
  for (const glm::vec3& p : places_m) {
    radius = std::max(radius, glm::length(p - centre_m));
    h = std::max(h, std::abs(glm::dot(p - centre_m, n)));
  }
  block->x[lane] = centre_m.x;
  block->y[lane] = centre_m.y;
  block->z[lane] = centre_m.z;
  block->r[lane] = Padded(radius, centre_m);
  block->nx[lane] = n.x;
  block->ny[lane] = n.y;
  block->nz[lane] = n.z;
  block->h[lane] = n == glm::vec3(0.0f) ? 0.0f : Padded(h, centre_m);
}

}  // namespace

std::vector<std::uint32_t> OrderInRuns(const std::vector<glm::dvec3>& places_m) {
  std::vector<std::uint32_t> order(places_m.size());
  std::iota(order.begin(), order.end(), 0U);
  SortIntoRuns(places_m, 0, order.size(), &order);
  return order;
}

SphereTree BuildSphereTree(std::span<const glm::vec3> places_m, std::span<const glm::vec3> leaf_normals) {
  SphereTree tree;
  std::size_t run = kBlock;                       // places under one sphere of this level
  std::size_t num_spheres = leaf_normals.size();  // of this level
  while (true) {
    tree.level_begin[tree.num_levels++] = static_cast<std::uint32_t>(tree.spheres.size());
    for (std::size_t j = 0; j < num_spheres; ++j) {
      if (j % kBlock == 0) tree.spheres.push_back(FarBlock());
      const auto within = places_m.subspan(j * run, std::min(run, places_m.size() - j * run));
      const glm::vec3 normal = tree.num_levels == 1 ? leaf_normals[j] : glm::vec3(0.0f);
      PutSphere(within, glm::vec3(SmallestSphere(within).centre), normal, j % kBlock, &tree.spheres.back());
    }
    if (num_spheres <= kBlock) break;
    num_spheres = (num_spheres + kBlock - 1) / kBlock;
    run *= kBlock;
  }
  return tree;
}

bool IsConsistent(const SphereTree& tree, std::size_t num_leaves) {
  if (tree.num_levels == 0 || tree.num_levels > SphereTree::kMaxLevels) return false;
  std::size_t spheres = num_leaves;
  std::size_t begin = 0;
  for (std::uint32_t level = 0; level < tree.num_levels; ++level) {
    const std::size_t blocks = (spheres + kBlock - 1) / kBlock;
    if (tree.level_begin[level] != begin || begin + blocks > tree.spheres.size()) return false;
    // Unused spheres of a block must be fillers, which no walk enters.
    const SphereBlock& last = tree.spheres[begin + blocks - 1];
    for (std::size_t lane = (spheres - 1) % kBlock + 1; lane < kBlock; ++lane) {
      if (last.x[lane] != SphereTree::kFarAway_m || last.r[lane] != 0.0f) return false;
    }
    begin += blocks;
    spheres = blocks;
  }
  return spheres == 1 && begin == tree.spheres.size();
}

}  // namespace vps
