#include "vps/field/crease.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/mesh/wide_clones.hpp"

namespace vps {
namespace {

constexpr int kRows = kNearRows;
constexpr int kNumPlaces = kRows * kRow;

// Corners, half way to the corners, middles of the faces, centre, and the centre once more to fill the rows.
struct Places {
  PointRow rows[kRows] = {};
  float x[kNumPlaces], y[kNumPlaces], z[kNumPlaces];

  constexpr Places() : x{}, y{}, z{} {
    for (int k = 0; k < 8; ++k) {
      Set(k, (k & 1) != 0 ? 0.48f : -0.48f, (k & 2) != 0 ? 0.48f : -0.48f, (k & 4) != 0 ? 0.48f : -0.48f);
      Set(8 + k, (k & 1) != 0 ? 0.24f : -0.24f, (k & 2) != 0 ? 0.24f : -0.24f, (k & 4) != 0 ? 0.24f : -0.24f);
    }
    for (int k = 0; k < 6; ++k) {
      const float at = (k & 1) != 0 ? 0.48f : -0.48f;
      Set(16 + k, k / 2 == 0 ? at : 0.0f, k / 2 == 1 ? at : 0.0f, k / 2 == 2 ? at : 0.0f);
    }
    Set(22, 0.0f, 0.0f, 0.0f);
    Set(23, 0.0f, 0.0f, 0.0f);
  }
  constexpr void Set(int i, float px, float py, float pz) {
    rows[i / kRow].x[i % kRow] = x[i] = px;
    rows[i / kRow].y[i % kRow] = y[i] = py;
    rows[i / kRow].z[i % kRow] = z[i] = pz;
  }
};
constexpr Places kPlaces;

// A value per place. Rows are vectors: the same operations lane by lane, and largest ones whatever the order.
using Lanes = float __attribute__((vector_size(kRow * sizeof(float))));
struct Values {
  union {
    float at[kNumPlaces];
    Lanes rows[kRows];
  };
};

[[gnu::always_inline]] inline void KeepLarger(const Lanes& v, Lanes* largest) {
  *largest = v > *largest ? v : *largest;
}
[[gnu::always_inline]] inline void KeepLargerSize(const Lanes& v, Lanes* largest) {
  KeepLarger(v < 0.0f ? -v : v, largest);
}
[[gnu::always_inline]] inline float Largest(const Lanes& v) {
  using Half = float __attribute__((vector_size(kRow / 2 * sizeof(float))));
  Half low, high;
  __builtin_memcpy(&low, &v, sizeof low);
  __builtin_memcpy(&high, reinterpret_cast<const char*>(&v) + sizeof low, sizeof high);
  const Half larger = low > high ? low : high;
  return std::max(std::max(larger[0], larger[2]), std::max(larger[1], larger[3]));
}

// The exact distance at the places, as tangent planes.
struct Exact {
  Values value;
  float at_centre[kNumPlaces];  // of the tangent
  glm::vec3 gradient[kNumPlaces];
  bool is_repeated[kNumPlaces];  // the same face's as an earlier one
};

[[gnu::always_inline]] inline void FindExact(const TriangleField& field, std::span<const NearTriangle> near,
                                             const glm::dvec3& first_sample, const glm::ivec3& cell,
                                             SettledSigns* around, Exact* out) {
  const glm::vec3 centre(cell);
  NearestOfPoints nearest;
  FindNearest(near, centre, kPlaces.rows, &nearest);
  std::uint32_t last_face = 0xffffffffU;
  for (int i = 0; i < kNumPlaces; ++i) {
    const glm::vec3 place(kPlaces.x[i], kPlaces.y[i], kPlaces.z[i]);
    const NearTriangle& triangle = near[nearest.triangle[i]];
    TangentPlane plane;
    if (field.side_is_sign() && nearest.is_over_face[i]) {
      plane = {nearest.height[i], triangle.rows->normal, true};
    } else {
      const glm::dvec3 p = first_sample + glm::dvec3(centre + place);
      plane = TangentOf(field.SignedValue(triangle.number, field.Closest(triangle.number, p), p, around));
    }
    out->value.at[i] = plane.distance;
    out->gradient[i] = plane.gradient;
    out->at_centre[i] = plane.distance - glm::dot(plane.gradient, place);
    out->is_repeated[i] = plane.is_over_face && triangle.number == last_face;
    if (plane.is_over_face) last_face = triangle.number;
  }
}

struct Candidate {
  std::uint32_t word = 0;
  Values value;  // of the plane as it will be read back

  explicit Candidate(std::uint32_t plane) : word(plane) {
    const float d = DistanceOf(word);
    const glm::vec3 g = GradientOf(word);
    for (int k = 0; k < kNumPlaces; ++k) {
      value.at[k] = d + ((g.x * kPlaces.x[k] + g.y * kPlaces.y[k]) + g.z * kPlaces.z[k]);
    }
  }
  Candidate() = default;
};

[[gnu::always_inline]] inline float LargestError(const Candidate& candidate, const Values& exact) {
  Lanes sizes{};
  for (int row = 0; row < kRows; ++row) KeepLargerSize(candidate.value.rows[row] - exact.rows[row], &sizes);
  return Largest(sizes);
}

// Planes nearer than this everywhere in the cell are merged, voxels. Not derived: a third of kGoodEnough, so that
// merging costs no accuracy that is sought.
constexpr float kSamePlane = 0.01f;

struct Tangents {
  Values exact;
  std::array<Candidate, kNumPlaces> candidates;
  int count = 0;

  explicit Tangents(const Exact& from) : exact(from.value) {
    for (int i = 0; i < kNumPlaces; ++i) {
      if (from.is_repeated[i] || std::abs(from.at_centre[i]) >= kLargestWordDistance) continue;
      Add(Candidate(EncodePlane(from.at_centre[i], from.gradient[i])));
    }
  }
  void Add(const Candidate& fresh) {
    for (int c = 0; c < count; ++c) {
      Lanes sizes{};  // planes differ most at the corners
      KeepLargerSize(candidates[c].value.rows[0] - fresh.value.rows[0], &sizes);
      if (Largest(sizes) < kSamePlane) return;
    }
    candidates[count++] = fresh;
  }
};

struct Choice {
  std::array<int, kPlanesPerCrease> planes{};
  float side = 1.0f;
  bool is_nested = false;
  float largest_error = std::numeric_limits<float>::infinity();
};

// One plane for all.
[[gnu::always_inline]] inline Choice BestPlane(const Tangents& tangents) {
  Choice choice;
  for (int c = 0; c < tangents.count; ++c) {
    const float largest = LargestError(tangents.candidates[c], tangents.exact);
    if (largest < choice.largest_error) {
      choice.largest_error = largest;
      choice.planes.fill(c);
    }
  }
  return choice;
}

// The plane of least squares: where facets are smaller than a voxel no single tangent represents the cell. The places
// are symmetric, so the normal equations decouple: distance = sum w d / sum w, slope_x = sum w d x / sum w x^2. The
// corners' weight w makes the mean of x^2 that of the cell, 1/12, so that a curved distance gives no bias: with the
// places at
// +-0.48 and +-0.24,  (1.8432 w + 0.9216) / (8 w + 15) = 1/12,  w = 0.279.
[[gnu::always_inline]] inline Candidate LeastSquares(const Values& exact) {
  constexpr float kCornerWeight = 0.28f;
  float weights = 0.0f;
  float sum = 0.0f;
  float squares = 0.0f;
  glm::vec3 slope(0.0f);
  for (int k = 0; k < kNumPlaces - 1; ++k) {  // the last repeats the centre
    const float weight = k < 8 ? kCornerWeight : 1.0f;
    const float value = weight * exact.at[k];
    weights += weight;
    sum += value;
    slope += value * glm::vec3(kPlaces.x[k], kPlaces.y[k], kPlaces.z[k]);
    squares += weight * kPlaces.x[k] * kPlaces.x[k];
  }
  return Candidate(EncodePlane(sum / weights, slope / squares));
}

// Error below which the search for a better combination ends, voxels. Not derived: half of kWorthARecord.
constexpr float kGoodEnough = 0.03f;

// Greedy fit of  side * d = max over planes of side * plane:  one plane after the other. Where the maximum is too large
// no later plane can lower it, so that overestimates weigh kTooMuch times as much. Not derived; with 1 the fit missed
// by 0.8 voxel (decision 5).
[[gnu::always_inline]] inline Choice BestLargest(const Tangents& tangents, float side) {
  constexpr float kTooMuch = 4.0f;
  Choice choice;
  choice.side = side;
  Values model;
  std::fill(std::begin(model.at), std::end(model.at), -std::numeric_limits<float>::max());
  for (std::uint32_t n = 0; n < kPlanesPerCrease; ++n) {
    int chosen = 0;
    float least = std::numeric_limits<float>::infinity();
    for (int c = 0; c < tangents.count; ++c) {
      const Values& value = tangents.candidates[c].value;
      Lanes overs{};
      Lanes unders{};
      Lanes sums{};
      for (int row = 0; row < kRows; ++row) {
        Lanes value_here = side * value.rows[row];
        KeepLarger(model.rows[row], &value_here);
        const Lanes error = value_here - side * tangents.exact.rows[row];
        KeepLarger(error, &overs);
        KeepLarger(-error, &unders);
        sums += error * error;
      }
      const float over = Largest(overs);
      const float under = Largest(unders);
      float sum = 0.0f;  // breaks ties between planes with the same largest error
      for (int i = 0; i < kRow; ++i) sum += sums[i];
      const float cost = kTooMuch * over + under + 0.01f * sum;
      if (cost < least) {
        least = cost;
        chosen = c;
      }
    }
    for (std::uint32_t k = n; k < kPlanesPerCrease; ++k) choice.planes[k] = chosen;
    Lanes sizes{};
    for (int row = 0; row < kRows; ++row) {
      KeepLarger(side * tangents.candidates[chosen].value.rows[row], &model.rows[row]);
      KeepLargerSize(model.rows[row] - side * tangents.exact.rows[row], &sizes);
    }
    choice.largest_error = Largest(sizes);
    if (choice.largest_error < kGoodEnough) break;
  }
  return choice;
}

// Two pairs:  side * d = max(min(a, b), min(c, e)).  All combinations of the planes in `pool`.
[[gnu::always_inline]] inline Choice BestNested(const Tangents& tangents, float side, std::span<const int> pool) {
  Choice choice;
  choice.side = side;
  choice.is_nested = true;
  struct Pair {
    int a, b;
    Values value;
  };
  std::array<Pair, 36> pairs;
  std::size_t num_pairs = 0;
  for (std::size_t i = 0; i < pool.size(); ++i) {
    for (std::size_t j = i; j < pool.size(); ++j) {
      Pair& pair = pairs[num_pairs++];
      pair.a = pool[i];
      pair.b = pool[j];
      for (int k = 0; k < kNumPlaces; ++k) {
        pair.value.at[k] =
            std::min(side * tangents.candidates[pair.a].value.at[k], side * tangents.candidates[pair.b].value.at[k]);
      }
    }
  }
  for (std::size_t i = 0; i < num_pairs; ++i) {
    // Where one pair is too large the maximum is, too.
    float over = 0.0f;
    for (int k = 0; k < kNumPlaces; ++k) {
      over = std::max(over, pairs[i].value.at[k] - side * tangents.exact.at[k]);
    }
    if (over >= choice.largest_error) continue;
    for (std::size_t j = i + 1; j < num_pairs; ++j) {
      Lanes sizes{};
      for (int row = 0; row < kRows; ++row) {
        Lanes model = pairs[i].value.rows[row];
        KeepLarger(pairs[j].value.rows[row], &model);
        KeepLargerSize(model - side * tangents.exact.rows[row], &sizes);
      }
      const float largest = Largest(sizes);
      if (largest < choice.largest_error) {
        choice.largest_error = largest;
        choice.planes = {pairs[i].a, pairs[i].b, pairs[j].a, pairs[j].b};
      }
    }
  }
  return choice;
}

// Reduction of the error, voxels, for which a cell gets a record: table of decision 6 ("examined, worth").
constexpr float kWorthARecord = 0.06f;
// Error of the simple combinations, voxels, above which nested ones are tried. Not derived: trades the build's time.
constexpr float kWorthASearch = 0.15f;
// Planes for nested combinations. Not derived: the time grows with the fourth power (36 pairs, 630 pairs of pairs).
constexpr std::size_t kPoolSize = 8;

[[gnu::always_inline]] inline void SearchNested(const Tangents& tangents, std::initializer_list<const Choice*> simple,
                                                Choice* best) {
  std::array<int, kPoolSize> pool{};
  std::size_t size = 0;
  const auto add = [&](int c) {
    if (size < kPoolSize && std::find(pool.begin(), pool.begin() + size, c) == pool.begin() + size) pool[size++] = c;
  };
  for (const Choice* choice : simple) {
    for (const int c : choice->planes) add(c);
  }
  for (int c = 0; c < tangents.count; ++c) add(c);
  for (const float side : {1.0f, -1.0f}) {
    const Choice nested = BestNested(tangents, side, {pool.data(), size});
    if (nested.largest_error < best->largest_error) *best = nested;
  }
}

}  // namespace

VPS_WIDE_CLONES CreaseFit FitCrease(const TriangleField& field, std::span<const NearTriangle> near,
                                    const glm::dvec3& first_sample, const glm::ivec3& cell, SettledSigns* around) {
  Exact exact;
  FindExact(field, near, first_sample, cell, around, &exact);
  const Candidate mean = LeastSquares(exact.value);
  CreaseFit fit;
  fit.planes.fill(mean.word);
  fit.largest_error = LargestError(mean, exact.value);
  if (fit.largest_error <= kWorthARecord) return fit;
  const Tangents tangents(exact);
  const Choice plane = BestPlane(tangents);
  const Choice convex = BestLargest(tangents, 1.0f);
  Choice concave;
  if (convex.largest_error > kGoodEnough) concave = BestLargest(tangents, -1.0f);
  Choice best = concave.largest_error < convex.largest_error ? concave : convex;
  if (best.largest_error > kWorthASearch) SearchNested(tangents, {&plane, &convex, &concave}, &best);
  if (plane.largest_error <= best.largest_error) best = plane;
  if (best.largest_error > fit.largest_error - kWorthARecord) return fit;
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
