#include "vps/field/build_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "vps/field/bound_cells.hpp"
#include "vps/field/brick_bins.hpp"
#include "vps/field/brick_pool.hpp"
#include "vps/field/brick_traits.hpp"
#include "vps/field/closest_triangle.hpp"
#include "vps/field/crease.hpp"
#include "vps/field/crease_cells.hpp"
#include "vps/field/far_cells.hpp"
#include "vps/field/field_plan.hpp"
#include "vps/field/mean_depths.hpp"
#include "vps/field/pack_facets.hpp"
#include "vps/field/tile_brick.hpp"
#include "vps/field/triangle_rows.hpp"

namespace vps {
namespace {

constexpr std::uint32_t kNoTriangle = 0xffffffffU;
// Not derived: tasks long against handing them out, and 512 drafts of bricks (2 KB each) in memory at once.
constexpr std::size_t kBricksPerTask = 4;
constexpr std::size_t kTasksAtOnce = 128;
constexpr std::size_t kRowsPerReport = 64;

// Progress at the end of each stage: its share of the build's time, as measured on finely tessellated meshes.
constexpr double kPreparedAt = 0.1;
constexpr double kCoarseAt = 0.2;
constexpr double kBricksAt = 0.9;

using BrickWords = std::array<std::uint32_t, DistanceField::kBrickWords>;

constexpr BrickWords EmptyBrick() {
  BrickWords words{};
  for (std::uint32_t& word : words) word = kCoarseWord;
  return words;
}
constexpr BrickWords kEmptyBrick = EmptyBrick();

// A layer of bricks while it and its neighbours are worked on: planes of single samples.
struct Layer {
  BrickPool pool;
  std::vector<std::uint32_t> first_word;     // of each place's brick in the pool
  std::vector<std::uint32_t> near_triangle;  // of each of the layer's bricks, kNoTriangle: no sample in the band
};

// A brick as its task leaves it, before it is stored in the field.
struct BrickDraft {
  BrickWords words;
  std::uint64_t hash = 0;              // of the words
  std::uint32_t near = kNoTriangle;    // a triangle near a sample in the band
  std::vector<std::uint32_t> records;  // of its creases; words number them from 0
};

// Facets wider than so many voxels have cells of their own and gain little from exact distances: they are kept only if
// they take 1 % of the field (decision 12, consequences).
constexpr double kWideFacet = 2.0;
constexpr double kWideFacetsShare = 0.01;
// For single places so much is kept whatever the field takes. Not derived: bounds memory.
constexpr std::size_t kSmallSurface_bytes = 1U << 20U;

double FacetsShare(const TriangleField& triangles) {
  double area = 0.0;  // voxels^2
  for (std::uint32_t i = 0; i < triangles.num_triangles(); ++i) {
    const auto [a, b, c] = triangles.corners(i);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  const double width = std::sqrt(area / static_cast<double>(triangles.num_triangles()));
  return width > kWideFacet ? kWideFacetsShare : kMostFacetsShare;
}

class FieldBuilder {
 public:
  FieldBuilder(TriangleField triangles, const FieldPlan& plan, const BuildFieldOptions& options)
      : triangles_(std::move(triangles)), options_(options), field_(plan.layout) {}

  core::Result<DistanceField> Build() {
    Report("bricks", kPreparedAt);
    if (auto room = MakeBricks(); !room) return tl::unexpected(room.error());
    FillCoarse();
    ComputeMeanDepths(&field_);
    FillBricks();
    if (field_.creases.size() / kPlanesPerCrease > kMaxCreases) {
      return core::Fail(core::ErrorCode::kResource,
                        "the field has more creases than its words can name; use larger voxels");
    }
    bins_ = {};
    field_.words.shrink_to_fit();
    field_.creases.shrink_to_fit();
    // Traits are sums over the triangles in order, which one worker makes.
    field_.coarse = BoundCells(field_, options_.workers, [this] {
      ComputeBrickTraits(*triangles_, &field_);
      KeepFacets();
    });
    triangles_.reset();
    Report("bounds", 1.0);
    return std::move(field_);
  }

 private:
  void Report(const char* stage, double fraction) const {
    if (options_.progress) options_.progress(stage, fraction);
  }

  void KeepFacets() {
    const auto share_of = [&](double share) {
      return static_cast<std::size_t>(share * static_cast<double>(field_.num_bytes()));
    };
    field_.facets = PackFacets(*triangles_, share_of(FacetsShare(*triangles_)));
    if (!field_.facets.blocks.empty()) return;
    field_.surface = PackFacets(*triangles_, std::max(share_of(kMostFacetsShare), kSmallSurface_bytes));
  }

  [[nodiscard]] glm::ivec3 GridBricks() const { return glm::ivec3(field_.nx, field_.ny, field_.nz) >> 3; }
  [[nodiscard]] std::size_t PlacesPerLayer() const {
    return static_cast<std::size_t>(field_.nx >> 3) * static_cast<std::size_t>(field_.ny >> 3);
  }
  [[nodiscard]] glm::ivec3 PlaceOf(std::size_t slot) const {
    const auto nx = static_cast<std::size_t>(field_.nx >> 3);
    return {slot % nx, slot % PlacesPerLayer() / nx, slot / PlacesPerLayer()};
  }
  [[nodiscard]] glm::ivec3 CornerOf(std::size_t b) const { return PlaceOf(slots_[b]) * DistanceField::kBrick; }

  core::Result<void> MakeBricks() {
    bins_ = BinTriangles(*triangles_, GridBricks(), DistanceField::kBandVoxels, &field_.bricks);
    slots_ = std::move(bins_.slot_of_brick);
    const std::size_t num_words = (slots_.size() + 1) * DistanceField::kBrickWords;
    if (static_cast<double>(num_words) * 8.0 > options_.max_peak_bytes || num_words > 0xffffffffU) {
      return core::Fail(core::ErrorCode::kResource,
                        "the field needs more memory than allowed: take larger voxels, or check that the mesh is in "
                        "metres");
    }
    return {};
  }

  // Layer by layer, so that of the single samples' planes only those of three are kept: a brick is examined beside the
  // 26 around it.
  void FillBricks() {
    std::fill(field_.bricks.begin(), field_.bricks.end(), 0);
    pool_.Reserve(slots_.size());
    drafts_.resize(std::min(kTasksAtOnce * kBricksPerTask, slots_.size()));
    const int num_layers = field_.nz >> 3;
    RasterLayer(0);
    for (int z = 0; z < num_layers; ++z) {
      if (z + 1 < num_layers) RasterLayer(z + 1);
      FinishLayer(z);
      Report("bricks", kCoarseAt + (kBricksAt - kCoarseAt) * (z + 1) / num_layers);
    }
    drafts_ = {};
    layers_ = {};
    field_.words = pool_.TakeWords();
    // Kernels may read whole records of lanes that have none.
    if (field_.creases.empty()) field_.creases.assign(kPlanesPerCrease, 0);
  }

  // Numbers of a layer's bricks: the first and the end.
  [[nodiscard]] std::pair<std::size_t, std::size_t> BricksOf(int z) const {
    const auto number_of = [&](std::size_t slot) {
      return static_cast<std::size_t>(std::lower_bound(slots_.begin(), slots_.end(), slot) - slots_.begin());
    };
    const std::size_t first = static_cast<std::size_t>(z) * PlacesPerLayer();
    return {number_of(first), number_of(first + PlacesPerLayer())};
  }

  // Calls draft(b, &draft) for a layer's bricks, sharing them out, and keep(b, draft) for one after the other in order.
  template <class Draft, class Keep>
  void ForBricks(int z, Draft&& draft, Keep&& keep) {
    const auto [begin, end] = BricksOf(z);
    for (std::size_t first = begin; first < end; first += drafts_.size()) {
      const std::size_t count = std::min(drafts_.size(), end - first);
      core::ForEach(options_.workers, (count + kBricksPerTask - 1) / kBricksPerTask, [&](std::size_t task) {
        const std::size_t last = std::min(count, (task + 1) * kBricksPerTask);
        for (std::size_t i = task * kBricksPerTask; i < last; ++i) draft(first + i, &drafts_[i]);
      });
      for (std::size_t i = 0; i < count; ++i) keep(first + i, &drafts_[i]);
    }
  }

  [[nodiscard]] Layer& LayerAt(int z) { return layers_[static_cast<std::size_t>(z % 3)]; }

  void RasterLayer(int z) {
    Layer& layer = LayerAt(z);
    layer = {};
    layer.first_word.assign(PlacesPerLayer(), 0);
    ForBricks(
        z, [&](std::size_t b, BrickDraft* draft) { RasterBrick(b, draft); },
        [&](std::size_t b, BrickDraft* draft) {
          layer.near_triangle.push_back(draft->near);
          if (draft->near == kNoTriangle) return;  // bins are generous
          layer.first_word[slots_[b] % PlacesPerLayer()] = layer.pool.Add(draft->words, draft->hash);
        });
  }

  void FinishLayer(int z) {
    const std::size_t begin = BricksOf(z).first;
    ForBricks(
        z,
        [&](std::size_t b, BrickDraft* draft) {
          draft->near = LayerAt(z).near_triangle[b - begin];
          if (draft->near != kNoTriangle) FinishBrick(b, draft);
        },
        [&](std::size_t b, BrickDraft* draft) {
          if (draft->near != kNoTriangle) field_.bricks[slots_[b]] = Keep(draft);
        });
  }

  // Stores the finished brick in the field; its first word.
  std::uint32_t Keep(BrickDraft* draft) {
    if (draft->records.empty()) return pool_.Add(draft->words, draft->hash);
    const std::size_t first = field_.creases.size() / kPlanesPerCrease;
    for (std::uint32_t& word : draft->words) {
      if (KindOf(word) == CellKind::kCrease) word = CreaseWord(RecordOf(word) + first);
    }
    field_.creases.insert(field_.creases.end(), draft->records.begin(), draft->records.end());
    return pool_.AddDistinct(draft->words);
  }

  void RasterBrick(std::size_t b, BrickDraft* draft) const {
    const glm::dvec3 origin = glm::dvec3(CornerOf(b)) + 0.5;
    const auto reach_voxels = static_cast<float>(DistanceField::kBandVoxels);
    NearestSamples samples(reach_voxels, kNoTriangle);
    const std::span<const std::uint32_t> numbers = bins_.of(b);
    const std::vector<RowTriangle> triangles = RowsOf(numbers, origin);
    for (std::uint32_t n = 0; n < numbers.size(); ++n) AddTriangle(triangles[n], n, reach_voxels, &samples);
    draft->near = kNoTriangle;
    draft->words = kEmptyBrick;
    const auto put = [&](std::uint32_t k, const TangentPlane& plane) {
      if (std::abs(plane.distance) > DistanceField::kBandVoxels) return;
      draft->near = numbers[samples.triangle[k]];
      draft->words[k] = EncodePlane(plane.distance, plane.gradient);
    };
    if (triangles_->side_is_sign()) {
      PutBySides(samples, numbers, triangles, origin, put);
    } else {
      PutByWinding(samples, numbers, origin, put);
    }
    draft->hash = BrickPool::HashOf(draft->words);
  }

  static glm::vec3 PlaceInBrick(std::uint32_t k) { return glm::vec3(k & 7, k >> 3 & 7, k >> 6); }

  // Calls put(k, plane) for the samples that have a nearest triangle.
  template <class Put>
  void PutBySides(const NearestSamples& samples, std::span<const std::uint32_t> numbers,
                  std::span<const RowTriangle> rows, const glm::dvec3& origin, const Put& put) const {
    for (std::uint32_t k = 0; k < DistanceField::kBrickWords; ++k) {
      const std::uint32_t n = samples.triangle[k];
      if (n == kNoTriangle) continue;
      const glm::vec3 place = PlaceInBrick(k);
      if (rows[n].IsOverFace(place)) {
        put(k, {rows[n].Height(place), rows[n].normal, true});
        continue;
      }
      const glm::dvec3 p = origin + glm::dvec3(place);
      put(k, TangentOf(triangles_->SignedValue(numbers[n], triangles_->Closest(numbers[n], p), p)));
    }
  }
  template <class Put>
  void PutByWinding(const NearestSamples& samples, std::span<const std::uint32_t> numbers, const glm::dvec3& origin,
                    const Put& put) const {
    std::array<ClosestFeature, DistanceField::kBrickWords> closest;
    const auto place_of = [&](std::size_t k) {
      return origin + glm::dvec3(PlaceInBrick(static_cast<std::uint32_t>(k)));
    };
    SampleSigns signs;
    for (std::uint32_t k = 0; k < DistanceField::kBrickWords; ++k) {
      const std::uint32_t n = samples.triangle[k];
      signs.radius[k] = -1.0f;
      if (n == kNoTriangle) continue;
      closest[k] = triangles_->Closest(numbers[n], place_of(k));
      signs.radius[k] = static_cast<float>(std::sqrt(closest[k].squared_distance));
      signs.is_wanted[k] = !triangles_->side_is_sign(numbers[n]);
    }
    signs.Settle(triangles_->signs_spread(),
                 [&](std::size_t k) { return static_cast<float>(triangles_->SignOfWinding(place_of(k))); });
    for (std::uint32_t k = 0; k < DistanceField::kBrickWords; ++k) {
      if (samples.triangle[k] == kNoTriangle) continue;
      const std::uint32_t t = numbers[samples.triangle[k]];
      const glm::dvec3 p = place_of(k);
      const double sign =
          signs.is_wanted[k] ? static_cast<double>(signs.sign[k]) : triangles_->SignOfSide(t, closest[k], p);
      put(k, TangentOf(triangles_->ValueWithSign(t, closest[k], p, sign)));
    }
  }

  // Of the triangles, about a brick's first sample.
  [[nodiscard]] std::vector<RowTriangle> RowsOf(std::span<const std::uint32_t> numbers,
                                                const glm::dvec3& first_sample) const {
    std::vector<RowTriangle> triangles;
    triangles.reserve(numbers.size());
    for (const std::uint32_t t : numbers) {
      const auto& [p, q, r] = triangles_->corners(t);
      triangles.emplace_back(p - first_sample, q - first_sample, r - first_sample);
    }
    return triangles;
  }

  // Of a brick with samples in the band, and of its neighbours, before anything is fitted.
  [[nodiscard]] Neighbourhood NeighbourhoodOf(std::size_t b) {
    const glm::ivec3 n = GridBricks();
    const glm::ivec3 place = PlaceOf(slots_[b]);
    Neighbourhood out;
    out.fill(kEmptyBrick.data());
    for (int k = 0; k < 27; ++k) {
      const glm::ivec3 c = place + glm::ivec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      if (glm::any(glm::lessThan(c, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(c, n))) continue;
      const Layer& layer = LayerAt(c.z);
      out[static_cast<std::size_t>(k)] = layer.pool.brick(layer.first_word[static_cast<std::size_t>(c.y) * n.x + c.x]);
    }
    return out;
  }

  void FinishBrick(std::size_t b, BrickDraft* draft) {
    const Neighbourhood around = NeighbourhoodOf(b);
    std::copy_n(around[13], DistanceField::kBrickWords, draft->words.begin());
    draft->records.clear();
    const ExaminedCells cells = ExamineCells(around);
    for (std::size_t k = 0; k < cells.lifts.size(); ++k) {
      if (cells.lifts[k] != 0) draft->words[k] = WithLift(draft->words[k], cells.lifts[k]);
    }
    FitBrick(b, cells.creases, around, draft);
    RepairFarCells(b, draft);
    TileBrick(&draft->words);
    if (draft->records.empty()) draft->hash = BrickPool::HashOf(draft->words);
  }

  // The nearest triangle t of a point p in a cell with centre c has  d(c, t) <= d(c) + 2 |p - c|  (triangle inequality,
  // twice). The places of FitCrease are at most 0.48 sqrt(3) = 0.832 from c.
  static constexpr float kAround = 2.0f * 0.84f;

  void FitBrick(std::size_t b, const CreaseCells& cells, const Neighbourhood& around, BrickDraft* draft) const {
    if (std::all_of(cells.begin(), cells.end(), [](std::uint8_t row) { return row == 0; })) return;
    const glm::dvec3 first_sample = glm::dvec3(CornerOf(b)) + 0.5;
    const std::span<const std::uint32_t> numbers = bins_.of(b);
    const std::vector<RowTriangle> triangles = RowsOf(numbers, first_sample);
    const TriangleBounds bounds(triangles);
    std::array<std::vector<NearTriangle>, kRow> near;
    for (int row = 0; row < 64; ++row) {
      const unsigned mask = cells[static_cast<std::size_t>(row)];
      if (mask == 0) continue;
      std::uint32_t* const words = &draft->words[static_cast<std::size_t>(row) * kRow];
      FindNear(triangles, bounds, numbers, row & 7, row >> 3, ReachesOf(words, mask).data(), &near);
      for (int x = 0; x < kRow; ++x) {
        if ((mask >> x & 1U) == 0 || near[static_cast<std::size_t>(x)].empty()) continue;
        const glm::ivec3 cell(x, row & 7, row >> 3);
        SettledSigns signs = SignsAround(around, cell, first_sample);
        const CreaseFit fit = FitCrease(*triangles_, near[static_cast<std::size_t>(x)], first_sample, cell, &signs);
        if (fit.kind == CellKind::kPlane) {
          if (std::isfinite(fit.largest_error)) words[x] = fit.planes[0];
          continue;
        }
        words[x] = CreaseWord(draft->records.size() / kPlanesPerCrease);
        draft->records.insert(draft->records.end(), fit.planes.begin(), fit.planes.end());
      }
    }
  }

  // Those of the centres of a cell and its neighbours, where they are in the band.
  [[nodiscard]] SettledSigns SignsAround(const Neighbourhood& around, const glm::ivec3& cell,
                                         const glm::dvec3& first_sample) const {
    SettledSigns signs(triangles_->signs_spread());
    if (!triangles_->signs_spread()) return signs;
    for (int k = 0; k < 27; ++k) {
      const glm::ivec3 c = cell + glm::ivec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const std::uint32_t word = WordAt(around, c.x, c.y, c.z);
      if (word == kCoarseWord) continue;
      const auto distance = static_cast<double>(DistanceOf(word));
      signs.Add(first_sample + glm::dvec3(c), std::abs(distance), distance < 0.0 ? -1.0 : 1.0);
    }
    return signs;
  }

  // Radius about the centre of each marked cell of a row that holds every triangle that may be nearest somewhere in the
  // cell; -1 for the others.
  [[nodiscard]] std::array<float, kRow> ReachesOf(const std::uint32_t* words, unsigned mask) const {
    std::array<float, kRow> reach;
    for (int x = 0; x < kRow; ++x) {
      const float d = std::abs(DistanceOf(words[x]));
      reach[static_cast<std::size_t>(x)] = (mask >> x & 1U) != 0 ? d + kAround : -1.0f;
    }
    return reach;
  }

  void FillCoarse() {
    const int shift = field_.coarse_shift;
    const glm::ivec3 n(field_.nx >> shift, field_.ny >> shift, field_.nz >> shift);
    field_.coarse.resize(static_cast<std::size_t>(n.x) * n.y * n.z);
    // A task is a row of cells along x: few enough to share out, and each cell's answer is a good guess for the next.
    const std::size_t num_rows = static_cast<std::size_t>(n.y) * n.z;
    for (std::size_t first = 0; first < num_rows; first += kRowsPerReport) {
      const std::size_t count = std::min(kRowsPerReport, num_rows - first);
      core::ForEach(options_.workers, count, [&](std::size_t i) {
        const std::size_t row = first + i;
        const glm::ivec3 start(0, static_cast<int>(row) % n.y, static_cast<int>(row) / n.y);
        std::uint32_t guess = 0;
        SettledSigns signs(triangles_->signs_spread());
        for (int x = 0; x < n.x; ++x)
          FillCoarseCell(start + glm::ivec3(x, 0, 0), &field_.coarse[row * n.x + x], &guess, &signs);
      });
      Report("coarse grid", kPreparedAt + (kCoarseAt - kPreparedAt) * static_cast<double>(first + count) /
                                              static_cast<double>(num_rows));
    }
  }

  void FillCoarseCell(const glm::ivec3& c, CoarseCell* cell, std::uint32_t* guess, SettledSigns* signs) const {
    const int shift = field_.coarse_shift;
    const glm::ivec3 place = ((c << shift) + (1 << shift >> 1)) >> 3;
    const glm::ivec3 n_bricks = GridBricks();
    const std::uint32_t b =
        field_.bricks[(static_cast<std::size_t>(place.z) * n_bricks.y + place.y) * n_bricks.x + place.x];
    if (b != kNoBrick) *guess = bins_.of(b).front();
    const glm::dvec3 p = (glm::dvec3(c) + 0.5) * static_cast<double>(1 << shift);
    const ClosestFeature closest = triangles_->ClosestOfAll(p, guess);
    const TriangleField::Value value = triangles_->SignedValue(*guess, closest, p, signs);
    cell->distance = static_cast<float>(value.distance);
    cell->gradient = EncodeCoarseGradient(glm::vec3(value.gradient));
  }

  // A coarse cell's plane is the tangent at its centre. Beside an edge of the part, or beyond a thin wall, it can come
  // near the surface, or pass through it, in voxels that are farther than the band: false contact. In a notch it can
  // overestimate the distance or the depth. Such voxels get planes of their own.
  //
  // In bricks that no sample of the band lies in, no plane reaches the surface: cells are no larger than the brick, the
  // nearest surface point F is 2.1 voxels or more from it, and the plane's least value over the brick is that of F's
  // projection.
  void RepairFarCells(std::size_t b, BrickDraft* draft) const {
    FarCells cells(field_, draft->records, CornerOf(b), draft->words.data());
    std::uint32_t guess = draft->near;
    SettledSigns signs(triangles_->signs_spread());
    while (const auto cell = cells.NextDoubtful()) {
      const glm::dvec3 p = glm::dvec3(CornerOf(b) + *cell) + 0.5;
      const ClosestFeature closest = triangles_->ClosestOfAll(p, &guess);
      const TriangleField::Value value = triangles_->SignedValue(guess, closest, p, &signs);
      cells.Put(*cell, static_cast<float>(value.distance), glm::vec3(value.gradient));
    }
  }

  std::optional<TriangleField> triangles_;
  const BuildFieldOptions& options_;
  DistanceField field_;
  BrickBins bins_;
  std::vector<std::uint32_t> slots_;  // of the bricks, ascending
  std::array<Layer, 3> layers_;       // the one being finished and its neighbours
  std::vector<BrickDraft> drafts_;
  BrickPool pool_;
};

TriangleMesh InVoxels(TriangleMesh mesh, const glm::dvec3& origin_m, double voxel_size_m) {
  for (glm::dvec3& v : mesh.vertices) v = (v - origin_m) / voxel_size_m;
  return mesh;
}

}  // namespace

core::Result<DistanceField> BuildField(const TriangleMesh& mesh, double voxel_size_m,
                                       const BuildFieldOptions& options) {
  const auto plan = PlanField(mesh, voxel_size_m, options);
  if (!plan) return tl::unexpected(plan.error());
  if (options.progress) options.progress("triangles", 0.0);
  TriangleField triangles(InVoxels(mesh, plan->layout.origin_m, voxel_size_m), options.signs, options.workers);
  if (triangles.num_triangles() == 0) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangle with an area");
  }
  return FieldBuilder(std::move(triangles), *plan, options).Build();
}

}  // namespace vps
