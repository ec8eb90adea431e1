#include "vps/field/crease.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vps {
namespace {

constexpr int kNumPlaces = 23;

// Centre, middles of the faces, corners, and half way to the corners.
std::array<glm::vec3, kNumPlaces> MakePlaces() {
  std::array<glm::vec3, kNumPlaces> places{};
  int n = 1;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float at : {-0.48f, 0.48f}) places[n++][axis] = at;
  }
  for (const float at : {0.24f, 0.48f}) {
    for (int k = 0; k < 8; ++k) {
      places[n++] = {(k & 1) != 0 ? at : -at, (k & 2) != 0 ? at : -at, (k & 4) != 0 ? at : -at};
    }
  }
  return places;
}

struct Candidate {
  std::uint32_t word = 0;
  std::array<float, kNumPlaces> value{};  // of the plane as it will be read back
};

struct Tangents {
  std::array<float, kNumPlaces> exact{};
  std::array<Candidate, kNumPlaces> candidates;
  int count = 0;
};

Tangents TakeTangents(const TriangleField& field, std::span<const std::uint32_t> triangles, const glm::dvec3& centre) {
  static const std::array<glm::vec3, kNumPlaces> places = MakePlaces();
  Tangents out;
  for (int i = 0; i < kNumPlaces; ++i) {
    const glm::dvec3 p = centre + glm::dvec3(places[i]);
    // The best of the near ones is the guess; slivers may lie between the samples.
    ClosestFeature best;
    std::uint32_t winner = triangles[0];
    for (const std::uint32_t t : triangles) {
      const ClosestFeature closest = field.Closest(t, p);
      if (closest.squared_distance < best.squared_distance) {
        best = closest;
        winner = t;
      }
    }
    best = field.ClosestOfAll(p, &winner);
    const TriangleField::Value value = field.SignedValue(winner, best, p);
    out.exact[i] = static_cast<float>(value.distance);
    const float at_centre = out.exact[i] - glm::dot(glm::vec3(value.gradient), places[i]);
    if (std::abs(at_centre) > kLargestWordDistance) continue;
    Candidate candidate;
    candidate.word = EncodePlane(at_centre, glm::vec3(value.gradient));
    bool is_new = true;
    for (int k = 0; k < out.count; ++k) is_new = is_new && out.candidates[k].word != candidate.word;
    if (!is_new) continue;
    const float d = DistanceOf(candidate.word);
    const glm::vec3 g = GradientOf(candidate.word);
    for (int k = 0; k < kNumPlaces; ++k) candidate.value[k] = d + glm::dot(g, places[k]);
    out.candidates[out.count++] = candidate;
  }
  return out;
}

struct Choice {
  std::array<int, kPlanesPerCrease> planes{};
  float side = 1.0f;
  bool is_nested = false;
  float largest_error = std::numeric_limits<float>::infinity();
};

// One plane for all.
Choice BestPlane(const Tangents& tangents) {
  Choice choice;
  for (int c = 0; c < tangents.count; ++c) {
    float largest = 0.0f;
    for (int k = 0; k < kNumPlaces; ++k) {
      largest = std::max(largest, std::abs(tangents.candidates[c].value[k] - tangents.exact[k]));
    }
    if (largest < choice.largest_error) {
      choice.largest_error = largest;
      choice.planes.fill(c);
    }
  }
  return choice;
}

// The largest of side * planes, one after the other. What a plane adds too much no later one takes away, so that
// weighs more.
Choice BestLargest(const Tangents& tangents, float side) {
  constexpr float kTooMuch = 4.0f;
  Choice choice;
  choice.side = side;
  std::array<float, kNumPlaces> model;
  model.fill(-std::numeric_limits<float>::infinity());
  for (std::uint32_t n = 0; n < kPlanesPerCrease; ++n) {
    int chosen = 0;
    float least = std::numeric_limits<float>::infinity();
    for (int c = 0; c < tangents.count; ++c) {
      float over = 0.0f;
      float under = 0.0f;
      float sum = 0.0f;
      for (int k = 0; k < kNumPlaces; ++k) {
        const float error = std::max(model[k], side * tangents.candidates[c].value[k]) - side * tangents.exact[k];
        over = std::max(over, error);
        under = std::max(under, -error);
        sum += error * error;
      }
      const float cost = kTooMuch * over + under + 0.01f * sum;
      if (cost < least) {
        least = cost;
        chosen = c;
      }
    }
    if (n == 0) choice.planes.fill(chosen);
    choice.planes[n] = chosen;
    choice.largest_error = 0.0f;
    for (int k = 0; k < kNumPlaces; ++k) {
      model[k] = std::max(model[k], side * tangents.candidates[chosen].value[k]);
      choice.largest_error = std::max(choice.largest_error, std::abs(model[k] - side * tangents.exact[k]));
    }
    if (choice.largest_error < 0.02f) break;
  }
  return choice;
}

// Two pairs: the larger of the two smaller ones. All combinations of the planes in `pool`.
Choice BestNested(const Tangents& tangents, float side, std::span<const int> pool) {
  Choice choice;
  choice.side = side;
  choice.is_nested = true;
  struct Pair {
    int a, b;
    std::array<float, kNumPlaces> value;
  };
  std::array<Pair, 36> pairs;
  std::size_t num_pairs = 0;
  for (std::size_t i = 0; i < pool.size(); ++i) {
    for (std::size_t j = i; j < pool.size(); ++j) {
      Pair& pair = pairs[num_pairs++];
      pair.a = pool[i];
      pair.b = pool[j];
      for (int k = 0; k < kNumPlaces; ++k) {
        pair.value[k] =
            std::min(side * tangents.candidates[pair.a].value[k], side * tangents.candidates[pair.b].value[k]);
      }
    }
  }
  for (std::size_t i = 0; i < num_pairs; ++i) {
    for (std::size_t j = i + 1; j < num_pairs; ++j) {
      float largest = 0.0f;
      for (int k = 0; k < kNumPlaces && largest < choice.largest_error; ++k) {
        largest =
            std::max(largest, std::abs(std::max(pairs[i].value[k], pairs[j].value[k]) - side * tangents.exact[k]));
      }
      if (largest < choice.largest_error) {
        choice.largest_error = largest;
        choice.planes = {pairs[i].a, pairs[i].b, pairs[j].a, pairs[j].b};
      }
    }
  }
  return choice;
}

constexpr float kWorthARecord = 0.02f;  // less error than one plane, voxels
constexpr float kWorthASearch = 0.08f;  // error of the simple combinations
constexpr std::size_t kPoolSize = 8;    // planes for nested combinations

}  // namespace

CreaseFit FitCrease(const TriangleField& field, std::span<const std::uint32_t> triangles, const glm::dvec3& centre) {
  const Tangents tangents = TakeTangents(field, triangles, centre);
  CreaseFit fit;
  if (tangents.count == 0) {
    fit.largest_error = std::numeric_limits<float>::infinity();
    return fit;
  }
  const Choice plane = BestPlane(tangents);
  const Choice convex = BestLargest(tangents, 1.0f);
  const Choice concave = BestLargest(tangents, -1.0f);
  Choice best = concave.largest_error < convex.largest_error ? concave : convex;
  if (best.largest_error > kWorthASearch) {
    std::array<int, kPoolSize> pool{};
    std::size_t size = 0;
    for (const Choice* choice : {&plane, &convex, &concave}) {
      for (const int c : choice->planes) {
        if (size < kPoolSize && std::find(pool.begin(), pool.begin() + size, c) == pool.begin() + size)
          pool[size++] = c;
      }
    }
    for (int c = 0; c < tangents.count && size < kPoolSize; ++c) {
      if (std::find(pool.begin(), pool.begin() + size, c) == pool.begin() + size) pool[size++] = c;
    }
    for (const float side : {1.0f, -1.0f}) {
      const Choice nested = BestNested(tangents, side, {pool.data(), size});
      if (nested.largest_error < best.largest_error) best = nested;
    }
  }
  if (best.largest_error > plane.largest_error - kWorthARecord) best = plane;
  const auto& chosen = best.planes;
  const bool is_plane = std::all_of(chosen.begin(), chosen.end(), [&](int c) { return c == chosen[0]; });
  fit.kind = is_plane ? CellKind::kPlane : CellKind::kCrease;
  fit.largest_error = best.largest_error;
  for (std::uint32_t k = 0; k < kPlanesPerCrease; ++k) fit.planes[k] = tangents.candidates[best.planes[k]].word;
  if (fit.kind == CellKind::kCrease) {
    fit.planes[0] = WithCombineBit(fit.planes[0], best.side < 0.0f);
    fit.planes[1] = WithCombineBit(fit.planes[1], best.is_nested);
  }
  return fit;
}

}  // namespace vps
