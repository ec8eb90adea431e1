#include "vps/field/crease.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vps {
namespace {

constexpr int kRows = 3;
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
  float largest = v[0];
  for (int i = 1; i < kRow; ++i) largest = std::max(largest, v[i]);
  return largest;
}

struct Candidate {
  std::uint32_t word = 0;
  Values value;  // of the plane as it will be read back
};

constexpr float kSamePlane = 0.01f;  // planes nearer than this everywhere in the cell are one

struct Tangents {
  Values exact;
  std::array<Candidate, kNumPlaces + 1> candidates;
  int count = 0;

  void Add(std::uint32_t word) {
    Candidate& fresh = candidates[count];
    fresh.word = word;
    const float d = DistanceOf(word);
    const glm::vec3 g = GradientOf(word);
    for (int k = 0; k < kNumPlaces; ++k) {
      fresh.value.at[k] = d + ((g.x * kPlaces.x[k] + g.y * kPlaces.y[k]) + g.z * kPlaces.z[k]);
    }
    for (int c = 0; c < count; ++c) {
      float largest = 0.0f;
      for (int k = 0; k < 8; ++k) {  // planes differ most at the corners
        largest = std::max(largest, std::abs(candidates[c].value.at[k] - fresh.value.at[k]));
      }
      if (largest < kSamePlane) return;
    }
    ++count;
  }
};

void TakeTangents(const TriangleField& field, std::span<const NearTriangle> near, const glm::dvec3& first_sample,
                  const glm::ivec3& cell, Tangents* out) {
  float squared[kNumPlaces];
  std::uint32_t winner[kNumPlaces];
  std::fill(std::begin(squared), std::end(squared), std::numeric_limits<float>::max());
  std::fill(std::begin(winner), std::end(winner), 0U);
  const glm::vec3 centre(cell);
  for (int row = 0; row < kRows; ++row) {
    PointRow points = kPlaces.rows[row];
    for (int i = 0; i < kRow; ++i) {
      points.x[i] += centre.x;
      points.y[i] += centre.y;
      points.z[i] += centre.z;
    }
    float* const least = squared + row * kRow;
    std::uint32_t* const nearest = winner + row * kRow;
    for (std::uint32_t n = 0; n < near.size(); ++n) {
      float here[kRow];
      SquaredDistances(*near[n].rows, points, here);
      for (int i = 0; i < kRow; ++i) {
        const bool is_nearer = here[i] < least[i];
        least[i] = is_nearer ? here[i] : least[i];
        nearest[i] = is_nearer ? n : nearest[i];
      }
    }
  }
  std::uint32_t last_face = 0xffffffffU;
  for (int i = 0; i < kNumPlaces; ++i) {
    const glm::vec3 place(kPlaces.x[i], kPlaces.y[i], kPlaces.z[i]);
    const NearTriangle& triangle = near[winner[i]];
    if (field.side_is_sign() && triangle.rows->IsOverFace(centre + place)) {
      // Over a face the plane's own side is the sign, and one tangent does for all its places.
      out->exact.at[i] = triangle.rows->Height(centre + place);
      if (triangle.number == last_face) continue;
      last_face = triangle.number;
      const float at_centre = triangle.rows->Height(centre);
      if (std::abs(at_centre) < kLargestWordDistance) out->Add(EncodePlane(at_centre, triangle.rows->normal));
      continue;
    }
    const glm::dvec3 p = first_sample + glm::dvec3(centre + place);
    const TriangleField::Value value = field.SignedValue(triangle.number, field.Closest(triangle.number, p), p);
    out->exact.at[i] = static_cast<float>(value.distance);
    const float at_centre = out->exact.at[i] - glm::dot(glm::vec3(value.gradient), place);
    if (std::abs(at_centre) < kLargestWordDistance) out->Add(EncodePlane(at_centre, glm::vec3(value.gradient)));
  }
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
    Lanes sizes{};
    for (int row = 0; row < kRows; ++row) {
      KeepLargerSize(tangents.candidates[c].value.rows[row] - tangents.exact.rows[row], &sizes);
    }
    const float largest = Largest(sizes);
    if (largest < choice.largest_error) {
      choice.largest_error = largest;
      choice.planes.fill(c);
    }
  }
  return choice;
}

// The plane of least squares: where facets are smaller than a voxel no single one of them speaks for the cell. The
// places lie symmetrically, so distance and slopes follow one by one. The corners weigh so much that the mean of x^2 is
// that of the cell, 1/12: a curved distance gives no bias.
void AddLeastSquares(Tangents* tangents) {
  constexpr float kCornerWeight = 0.28f;
  float weights = 0.0f;
  float sum = 0.0f;
  float squares = 0.0f;
  glm::vec3 slope(0.0f);
  for (int k = 0; k < kNumPlaces - 1; ++k) {  // the last repeats the centre
    const float weight = k < 8 ? kCornerWeight : 1.0f;
    const float value = weight * tangents->exact.at[k];
    weights += weight;
    sum += value;
    slope += value * glm::vec3(kPlaces.x[k], kPlaces.y[k], kPlaces.z[k]);
    squares += weight * kPlaces.x[k] * kPlaces.x[k];
  }
  const float d = sum / weights;
  if (std::abs(d) < kLargestWordDistance) tangents->Add(EncodePlane(d, slope / squares));
}

constexpr float kGoodEnough = 0.03f;  // error at which no better combination is looked for

// The largest of side * planes, one after the other. What a plane adds too much no later one takes away, so that
// weighs more.
Choice BestLargest(const Tangents& tangents, float side) {
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
      float sum = 0.0f;  // tells planes apart that leave the largest error to others
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

// Two pairs: the larger of the two smaller ones. All combinations of the planes in `pool`.
Choice BestNested(const Tangents& tangents, float side, std::span<const int> pool) {
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
    // What one pair has too much the other does not take away.
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

constexpr float kWorthARecord = 0.06f;  // less error than one plane, voxels
constexpr float kWorthASearch = 0.15f;  // error of the simple combinations
constexpr std::size_t kPoolSize = 8;    // planes for nested combinations

void SearchNested(const Tangents& tangents, std::initializer_list<const Choice*> simple, Choice* best) {
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

CreaseFit FitCrease(const TriangleField& field, std::span<const NearTriangle> near, const glm::dvec3& first_sample,
                    const glm::ivec3& cell) {
  Tangents tangents;
  TakeTangents(field, near, first_sample, cell, &tangents);
  CreaseFit fit;
  if (tangents.count == 0) {
    fit.largest_error = std::numeric_limits<float>::infinity();
    return fit;
  }
  const int num_tangents = tangents.count;  // only they combine: a mean plane cuts through what they touch
  AddLeastSquares(&tangents);
  const Choice plane = BestPlane(tangents);
  tangents.count = num_tangents;
  Choice best = plane;
  if (plane.largest_error > kWorthARecord) {
    const Choice convex = BestLargest(tangents, 1.0f);
    Choice concave;
    if (convex.largest_error > kGoodEnough) concave = BestLargest(tangents, -1.0f);
    best = concave.largest_error < convex.largest_error ? concave : convex;
    if (best.largest_error > kWorthASearch) SearchNested(tangents, {&plane, &convex, &concave}, &best);
    if (best.largest_error > plane.largest_error - kWorthARecord) best = plane;
  }
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
