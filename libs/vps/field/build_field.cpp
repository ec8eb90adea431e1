#include "vps/field/build_field.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "vps/field/bound_cells.hpp"
#include "vps/field/brick_bins.hpp"
#include "vps/field/closest_triangle.hpp"
#include "vps/field/crease.hpp"
#include "vps/field/crease_cells.hpp"
#include "vps/field/far_cells.hpp"
#include "vps/field/field_plan.hpp"
#include "vps/field/surface_bends.hpp"
#include "vps/field/tile_bricks.hpp"
#include "vps/field/triangle_rows.hpp"

namespace vps {
namespace {

constexpr std::uint32_t kNoTriangle = 0xffffffffU;
constexpr std::size_t kBricksPerTask = 16;
constexpr std::size_t kTasksPerReport = 64;

// Where each stage ends in the whole build's time, as measured on finely tessellated meshes.
constexpr double kPreparedAt = 0.1;
constexpr double kRasteredAt = 0.5;
constexpr double kCreasesAt = 0.9;
constexpr double kCoarseAt = 0.98;

class FieldBuilder {
 public:
  FieldBuilder(TriangleField triangles, const FieldPlan& plan, const BuildFieldOptions& options)
      : triangles_(std::move(triangles)),
        half_thickness_(plan.half_thickness),
        options_(options),
        field_(plan.layout) {}

  core::Result<DistanceField> Build() {
    Report("bricks", kPreparedAt);
    if (auto room = MakeBricks(); !room) return tl::unexpected(room.error());
    RasterBricks();
    DropEmptyBricks();
    FitCreases();
    bins_ = {};
    FillCoarse();
    MendFarCells();
    field_.bends = SurfaceBends(*triangles_, field_);
    triangles_.reset();
    field_.words.shrink_to_fit();
    field_.creases.shrink_to_fit();
    TileBricks(&field_);
    BoundCells(&field_, options_.workers);
    Report("coarse grid", 1.0);
    return std::move(field_);
  }

 private:
  void Report(const char* stage, double fraction) const {
    if (options_.progress) options_.progress(stage, fraction);
  }

  // Calls work(task) for every task, sharing them out, and tells the progress between `begin` and `end`.
  template <class Work>
  void RunTasks(const char* stage, double begin, double end, std::size_t count, Work&& work) {
    for (std::size_t first = 0; first < count; first += kTasksPerReport) {
      core::ForEach(options_.workers, std::min(kTasksPerReport, count - first),
                    [&](std::size_t i) { work(first + i); });
      const double done = static_cast<double>(std::min(first + kTasksPerReport, count)) / static_cast<double>(count);
      Report(stage, begin + (end - begin) * done);
    }
  }
  template <class Work>
  void ForEachBrick(const char* stage, double begin, double end, Work&& work) {
    const std::size_t num_tasks = (slots_.size() + kBricksPerTask - 1) / kBricksPerTask;
    RunTasks(stage, begin, end, num_tasks, [&](std::size_t task) {
      const std::size_t last = std::min(slots_.size(), (task + 1) * kBricksPerTask);
      for (std::size_t b = task * kBricksPerTask; b < last; ++b) work(b);
    });
  }

  // First word of a brick; brick 0 of the words stands for every place without a sample in the band.
  static std::size_t FirstWord(std::size_t brick) { return (brick + 1) * DistanceField::kBrickWords; }
  [[nodiscard]] glm::ivec3 CornerOf(std::size_t slot) const {
    const auto nx = static_cast<std::size_t>(field_.nx >> 3);
    const auto ny = static_cast<std::size_t>(field_.ny >> 3);
    return glm::ivec3(slot % nx, slot / nx % ny, slot / (nx * ny)) * DistanceField::kBrick;
  }

  core::Result<void> MakeBricks() {
    bins_ = BinTriangles(*triangles_, glm::ivec3(field_.nx, field_.ny, field_.nz) / DistanceField::kBrick, reach(),
                         &field_.bricks);
    slots_ = std::move(bins_.slot_of_brick);
    for (std::uint32_t& brick : field_.bricks) {
      brick = brick == kNoBrick ? 0 : static_cast<std::uint32_t>(FirstWord(brick));
    }
    const std::size_t num_words = FirstWord(slots_.size());
    if (static_cast<double>(num_words) * 8.0 > options_.max_peak_bytes || num_words > 0xffffffffU) {
      return core::Fail(core::ErrorCode::kResource,
                        "the field needs more memory than allowed: take larger voxels, or check that the mesh is in "
                        "metres");
    }
    field_.words.assign(num_words, kCoarseWord);
    near_brick_.assign(slots_.size(), kNoTriangle);
    return {};
  }

  void RasterBricks() {
    ForEachBrick("triangles to bricks", kPreparedAt, kRasteredAt, [&](std::size_t b) { RasterBrick(b); });
  }

  void RasterBrick(std::size_t b) {
    const glm::ivec3 corner = CornerOf(slots_[b]);
    const glm::dvec3 origin = glm::dvec3(corner) + 0.5;
    NearestSamples samples;
    const auto reach_voxels = static_cast<float>(reach());
    std::fill(std::begin(samples.squared), std::end(samples.squared), reach_voxels * reach_voxels);
    std::fill(std::begin(samples.triangle), std::end(samples.triangle), kNoTriangle);
    const std::span<const std::uint32_t> numbers = bins_.of(b);
    const std::vector<RowTriangle> triangles = RowsOf(numbers, origin);
    for (std::uint32_t n = 0; n < numbers.size(); ++n) AddTriangle(triangles[n], n, reach_voxels, &samples);
    std::uint32_t* const words = field_.words.data() + FirstWord(b);
    for (std::uint32_t k = 0; k < DistanceField::kBrickWords; ++k) {
      const std::uint32_t n = samples.triangle[k];
      if (n == kNoTriangle) continue;
      const glm::ivec3 place(k & 7, k >> 3 & 7, k >> 6);
      const TangentPlane plane = TangentAt(*triangles_, {numbers[n], &triangles[n]}, origin, glm::vec3(place));
      if (std::abs(plane.distance) > DistanceField::kBandVoxels) continue;  // deep in a thick sheet
      near_brick_[b] = numbers[n];
      words[k] = EncodePlane(plane.distance, plane.gradient);
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

  // Bins are generous: bricks that no sample of the band lies in go.
  void DropEmptyBricks() {
    bin_of_brick_.resize(slots_.size());
    std::iota(bin_of_brick_.begin(), bin_of_brick_.end(), 0U);
    std::size_t kept = 0;
    for (std::size_t b = 0; b < slots_.size(); ++b) {
      if (near_brick_[b] == kNoTriangle) {
        field_.bricks[slots_[b]] = 0;
        continue;
      }
      if (kept != b) {
        const std::size_t from = FirstWord(b);
        const std::size_t to = FirstWord(kept);
        std::copy_n(&field_.words[from], DistanceField::kBrickWords, &field_.words[to]);
        near_brick_[kept] = near_brick_[b];
        slots_[kept] = slots_[b];
        bin_of_brick_[kept] = bin_of_brick_[b];
        field_.bricks[slots_[kept]] = static_cast<std::uint32_t>(to);
      }
      ++kept;
    }
    slots_.resize(kept);
    field_.words.resize(FirstWord(kept));
  }

  void FitCreases() {
    std::vector<ExaminedCells> cells(slots_.size());
    ForEachBrick("creases", kRasteredAt, kRasteredAt + 0.1,
                 [&](std::size_t b) { cells[b] = ExamineCells(field_.words, NeighbourhoodOf(field_, slots_[b])); });
    // Records are numbered within their task first, so that the order of the tasks' ends does not matter.
    const std::size_t num_tasks = (slots_.size() + kBricksPerTask - 1) / kBricksPerTask;
    std::vector<std::vector<std::uint32_t>> records(num_tasks);
    ForEachBrick("creases", kRasteredAt + 0.1, kCreasesAt, [&](std::size_t b) {
      LiftPlanes(b, cells[b].lifts);
      FitBrick(b, cells[b].creases, &records[b / kBricksPerTask]);
    });
    std::size_t sum = 0;
    for (const auto& part : records) sum += part.size();
    field_.creases.reserve(std::max<std::size_t>(sum, kPlanesPerCrease));
    for (std::size_t task = 0; task < num_tasks; ++task) {
      const std::size_t first = field_.creases.size() / kPlanesPerCrease;
      field_.creases.insert(field_.creases.end(), records[task].begin(), records[task].end());
      if (first == 0 || records[task].empty()) continue;
      const std::size_t end = FirstWord(std::min(slots_.size(), (task + 1) * kBricksPerTask));
      for (std::size_t i = FirstWord(task * kBricksPerTask); i < end; ++i) {
        std::uint32_t& word = field_.words[i];
        if (KindOf(word) == CellKind::kCrease) word = CreaseWord(RecordOf(word) + first);
      }
    }
    // Kernels may read whole records of lanes that have none.
    if (field_.creases.empty()) field_.creases.assign(kPlanesPerCrease, 0);
  }

  void LiftPlanes(std::size_t b, const std::array<std::int8_t, DistanceField::kBrickWords>& lifts) {
    std::uint32_t* const words = &field_.words[FirstWord(b)];
    for (std::size_t k = 0; k < lifts.size(); ++k) {
      if (lifts[k] != 0) words[k] = WithLift(words[k], lifts[k]);
    }
  }

  // The nearest triangle of a point in a cell is nearer to the cell's centre than the centre's own by no more than
  // twice the way from the centre to the point.
  static constexpr float kAround = 2.0f * 0.84f;

  void FitBrick(std::size_t b, const CreaseCells& cells, std::vector<std::uint32_t>* records) {
    if (std::all_of(cells.begin(), cells.end(), [](std::uint8_t row) { return row == 0; })) return;
    const glm::dvec3 first_sample = glm::dvec3(CornerOf(slots_[b])) + 0.5;
    const std::span<const std::uint32_t> numbers = bins_.of(bin_of_brick_[b]);
    const std::vector<RowTriangle> triangles = RowsOf(numbers, first_sample);
    std::array<std::vector<NearTriangle>, kRow> near;
    for (int row = 0; row < 64; ++row) {
      const unsigned mask = cells[static_cast<std::size_t>(row)];
      if (mask == 0) continue;
      std::uint32_t* const words = &field_.words[FirstWord(b) + static_cast<std::size_t>(row) * kRow];
      FindNear(words, mask, row, numbers, triangles, &near);
      for (int x = 0; x < kRow; ++x) {
        if ((mask >> x & 1U) == 0 || near[static_cast<std::size_t>(x)].empty()) continue;
        const CreaseFit fit =
            FitCrease(*triangles_, near[static_cast<std::size_t>(x)], first_sample, {x, row & 7, row >> 3});
        if (fit.kind == CellKind::kPlane) {
          if (std::isfinite(fit.largest_error)) words[x] = fit.planes[0];
          continue;
        }
        words[x] = CreaseWord(records->size() / kPlanesPerCrease);
        records->insert(records->end(), fit.planes.begin(), fit.planes.end());
      }
    }
  }

  // Triangles that may be nearest somewhere in a cell, for the marked cells of a row.
  void FindNear(const std::uint32_t* words, unsigned mask, int row, std::span<const std::uint32_t> numbers,
                const std::vector<RowTriangle>& triangles, std::array<std::vector<NearTriangle>, kRow>* near) const {
    float reach[kRow];
    float largest = 0.0f;
    for (int x = 0; x < kRow; ++x) {
      const bool is_marked = (mask >> x & 1U) != 0;
      const float d = std::abs(DistanceOf(words[x]) + static_cast<float>(half_thickness_));
      reach[x] = is_marked ? (d + kAround) * (d + kAround) : -1.0f;
      largest = std::max(largest, is_marked ? d + kAround : 0.0f);
      (*near)[static_cast<std::size_t>(x)].clear();
    }
    for (std::size_t n = 0; n < triangles.size(); ++n) {
      float squared[kRow];
      if (!SampleDistances(triangles[n], row & 7, row >> 3, largest, squared)) continue;
      for (int x = 0; x < kRow; ++x) {
        if (squared[x] <= reach[x]) (*near)[static_cast<std::size_t>(x)].push_back({numbers[n], &triangles[n]});
      }
    }
  }

  void FillCoarse() {
    const int shift = field_.coarse_shift;
    const glm::ivec3 n(field_.nx >> shift, field_.ny >> shift, field_.nz >> shift);
    field_.coarse.resize(static_cast<std::size_t>(n.x) * n.y * n.z);
    // A task is a row of cells along x: few enough to share out, and each cell's answer is a good guess for the next.
    RunTasks("coarse grid", kCreasesAt, kCoarseAt, static_cast<std::size_t>(n.y) * n.z, [&](std::size_t row) {
      const glm::ivec3 start(0, static_cast<int>(row) % n.y, static_cast<int>(row) / n.y);
      std::uint32_t guess = 0;
      for (int x = 0; x < n.x; ++x) FillCoarseCell(start + glm::ivec3(x, 0, 0), &field_.coarse[row * n.x + x], &guess);
    });
  }

  void FillCoarseCell(const glm::ivec3& c, CoarseCell* cell, std::uint32_t* guess) const {
    const int shift = field_.coarse_shift;
    const glm::ivec3 brick = ((c << shift) + (1 << shift >> 1)) >> 3;
    const std::size_t slot =
        (static_cast<std::size_t>(brick.z) * (field_.ny >> 3) + brick.y) * (field_.nx >> 3) + brick.x;
    if (const std::uint32_t first = field_.bricks[slot]; first != 0) {
      *guess = near_brick_[first / DistanceField::kBrickWords - 1];
    }
    const glm::dvec3 p = (glm::dvec3(c) + 0.5) * static_cast<double>(1 << shift);
    const ClosestFeature closest = triangles_->ClosestOfAll(p, guess);
    const TriangleField::Value value = triangles_->SignedValue(*guess, closest, p);
    cell->distance = static_cast<float>(value.distance);
    cell->gradient = EncodeCoarseGradient(glm::vec3(value.gradient));
  }

  // A coarse cell's plane is the tangent at its centre. Beside an edge of the part, or beyond a thin wall, it comes
  // near the surface, or through it, in voxels that are farther than the band, and tells of contact where there is
  // none; in a notch it tells of more room, or more depth, than there is. Such voxels get planes of their own.
  //
  // In bricks that no sample of the band lies in, no plane reaches the surface: cells are no larger than the brick, the
  // nearest surface point F is 2.1 voxels or more from it, and the plane's least value over the brick is that of F's
  // projection.
  void MendFarCells() {
    ForEachBrick("far cells", kCoarseAt, 1.0, [&](std::size_t b) {
      FarCells cells(field_, CornerOf(slots_[b]), &field_.words[FirstWord(b)]);
      std::uint32_t guess = near_brick_[b];
      while (const auto cell = cells.NextDoubtful()) {
        const glm::dvec3 p = glm::dvec3(CornerOf(slots_[b]) + *cell) + 0.5;
        const ClosestFeature closest = triangles_->ClosestOfAll(p, &guess);
        const TriangleField::Value value = triangles_->SignedValue(guess, closest, p);
        cells.Put(*cell, static_cast<float>(value.distance), glm::vec3(value.gradient));
      }
    });
  }

  [[nodiscard]] double reach() const { return half_thickness_ + DistanceField::kBandVoxels; }

  std::optional<TriangleField> triangles_;
  double half_thickness_;
  const BuildFieldOptions& options_;
  DistanceField field_;
  BrickBins bins_;
  std::vector<std::uint32_t> slots_;         // of the bricks, ascending
  std::vector<std::uint32_t> bin_of_brick_;  // before bricks were dropped
  std::vector<std::uint32_t> near_brick_;    // a triangle near each brick, kNoTriangle: no sample in the band
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
  TriangleField triangles(InVoxels(mesh, plan->layout.origin_m, voxel_size_m), plan->half_thickness,
                          options.sign_by_winding);
  if (triangles.num_triangles() == 0) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangle with an area");
  }
  return FieldBuilder(std::move(triangles), *plan, options).Build();
}

}  // namespace vps
