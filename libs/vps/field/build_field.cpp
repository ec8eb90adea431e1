#include "vps/field/build_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "vps/field/band_raster.hpp"
#include "vps/field/closest_triangle.hpp"
#include "vps/field/crease.hpp"

namespace vps {
namespace {

// A neighbour's distance may differ from the cell's tangent plane by this much times the squared distance of the two
// centres (a radius of curvature of 12 voxels) before the cell is examined as a crease.
constexpr float kCreaseTolerance = 0.04f;
constexpr std::size_t kMaxCoarseCells = 4'000'000;

int RoundUp(int value, int step) {
  return (value + step - 1) / step * step;
}

void FillCoarse(const TriangleField& triangles, const std::function<void(std::string_view, double)>& progress,
                DistanceField* field) {
  const int shift = field->coarse_shift;
  const glm::ivec3 n(field->nx >> shift, field->ny >> shift, field->nz >> shift);
  const double step = 1 << shift;
  field->coarse.resize(static_cast<std::size_t>(n.x) * n.y * n.z);
  std::uint32_t plane_guess = 0;
  for (int z = 0; z < n.z; ++z) {
    std::uint32_t row_guess = plane_guess;
    for (int y = 0; y < n.y; ++y) {
      std::uint32_t guess = row_guess;
      for (int x = 0; x < n.x; ++x) {
        const glm::dvec3 p = (glm::dvec3(x, y, z) + 0.5) * step;
        const ClosestFeature closest = triangles.ClosestOfAll(p, &guess);
        const TriangleField::Value value = triangles.SignedValue(guess, closest, p);
        CoarseCell& cell = field->coarse[(static_cast<std::size_t>(z) * n.y + y) * n.x + x];
        cell.distance = static_cast<float>(value.distance);
        cell.gradient = EncodeCoarseGradient(glm::vec3(value.gradient));
        if (x == 0) row_guess = guess;
      }
      if (y == 0) plane_guess = row_guess;
    }
    if (progress) progress("distance field: coarse", static_cast<double>(z + 1) / n.z);
  }
}

// Planes of a brick and one sample around it.
class Apron {
 public:
  static constexpr int kSide = 10;
  struct Sample {
    glm::vec3 gradient;
    float distance;  // infinite: none
  };

  Apron(const DistanceField& field, const std::vector<std::uint32_t>& planes, const glm::ivec3& brick) {
    const glm::ivec3 n(field.nx, field.ny, field.nz);
    for (int z = -1; z <= 8; ++z) {
      for (int y = -1; y <= 8; ++y) {
        for (int x = -1; x <= 8; ++x) {
          Sample& sample = at({x, y, z});
          sample.distance = INFINITY;
          const glm::ivec3 c = brick * 8 + glm::ivec3(x, y, z);
          if (c.x < 0 || c.y < 0 || c.z < 0 || c.x >= n.x || c.y >= n.y || c.z >= n.z) continue;
          const std::size_t slot =
              (static_cast<std::size_t>(c.z >> 3) * (n.y >> 3) + (c.y >> 3)) * (n.x >> 3) + (c.x >> 3);
          const std::uint32_t word =
              planes[field.bricks[slot] + static_cast<std::uint32_t>((c.z & 7) << 6 | (c.y & 7) << 3 | (c.x & 7))];
          if (KindOf(word) == CellKind::kCoarse) continue;
          sample = {GradientOf(word), DistanceOf(word)};
        }
      }
    }
  }
  Sample& at(const glm::ivec3& c) { return samples_[((c.z + 1) * kSide + c.y + 1) * kSide + c.x + 1]; }

  // Whether the tangent plane of sample c misses a neighbour.
  bool IsCrease(const glm::ivec3& c) {
    const Sample& own = at(c);
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          const Sample& other = at(c + glm::ivec3(x, y, z));
          if (other.distance == INFINITY) continue;
          const glm::vec3 r(x, y, z);
          const float miss = std::abs(own.distance + glm::dot(own.gradient, r) - other.distance);
          if (miss > kCreaseTolerance * glm::dot(r, r)) return true;
        }
      }
    }
    return false;
  }

 private:
  std::array<Sample, kSide * kSide * kSide> samples_;
};

void FillBricks(const TriangleField& triangles, const BandBricks& band,
                const std::function<void(std::string_view, double)>& progress, DistanceField* field) {
  // Brick 0 stands for every brick without a sample in the band.
  field->words.assign((band.bricks.size() + 1) * DistanceField::kBrickWords, kCoarseWord);
  field->bricks.assign(band.index.size(), 0);
  for (std::size_t i = 0; i < band.index.size(); ++i) {
    if (band.index[i] != BandBricks::kNone) field->bricks[i] = (band.index[i] + 1) * DistanceField::kBrickWords;
  }
  for (std::size_t b = 0; b < band.bricks.size(); ++b) {
    const BandBricks::Brick& brick = *band.bricks[b];
    for (std::uint32_t k = 0; k < DistanceField::kBrickWords; ++k) {
      if (brick.triangle[k] == BandBricks::kNone) continue;
      const glm::dvec3 p = glm::dvec3(brick.cell * 8 + glm::ivec3(k & 7, k >> 3 & 7, k >> 6)) + 0.5;
      const auto value = triangles.SignedValue(brick.triangle[k], triangles.Closest(brick.triangle[k], p), p);
      if (std::abs(value.distance) > DistanceField::kBandVoxels) continue;  // deep in a thick sheet
      field->words[(b + 1) * DistanceField::kBrickWords + k] =
          EncodePlane(static_cast<float>(value.distance), glm::vec3(value.gradient));
    }
    if (progress && b % 4096 == 0) {
      progress("distance field: band", static_cast<double>(b) / static_cast<double>(band.bricks.size()));
    }
  }
}

void FitCreases(const TriangleField& triangles, const BandBricks& band,
                const std::function<void(std::string_view, double)>& progress, DistanceField* field) {
  const std::vector<std::uint32_t> planes = field->words;
  std::vector<std::uint32_t> near;
  for (std::size_t b = 0; b < band.bricks.size(); ++b) {
    const BandBricks::Brick& brick = *band.bricks[b];
    Apron apron(*field, planes, brick.cell);
    for (std::uint32_t k = 0; k < DistanceField::kBrickWords; ++k) {
      if (brick.triangle[k] == BandBricks::kNone) continue;
      const glm::ivec3 c(k & 7, k >> 3 & 7, k >> 6);
      if (KindOf(planes[(b + 1) * DistanceField::kBrickWords + k]) == CellKind::kCoarse || !apron.IsCrease(c)) continue;
      const glm::ivec3 voxel = brick.cell * 8 + c;
      near.clear();
      for (int n = 0; n < 27; ++n) {
        const std::uint32_t t = band.TriangleAt(voxel + glm::ivec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
        if (t != BandBricks::kNone) near.push_back(t);
      }
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      const CreaseFit fit = FitCrease(triangles, near, glm::dvec3(voxel) + 0.5);
      std::uint32_t& word = field->words[(b + 1) * DistanceField::kBrickWords + k];
      if (fit.kind == CellKind::kPlane) {
        if (std::isfinite(fit.largest_error)) word = fit.planes[0];
        continue;
      }
      // A word numbers 33 million records; after those the tangent plane stays.
      if (field->creases.size() / kPlanesPerCrease >= kMaxCreases) continue;
      word = CreaseWord(field->creases.size() / kPlanesPerCrease);
      field->creases.insert(field->creases.end(), fit.planes.begin(), fit.planes.end());
    }
    if (progress && b % 1024 == 0) {
      progress("distance field: creases", static_cast<double>(b) / static_cast<double>(band.bricks.size()));
    }
  }
  // Kernels may read whole records of lanes that have none.
  if (field->creases.empty()) field->creases.assign(kPlanesPerCrease, 0);
}

}  // namespace

core::Result<DistanceField> BuildField(const TriangleMesh& mesh, double voxel_size_m,
                                       const BuildFieldOptions& options) {
  if (!(voxel_size_m > 0.0) || !std::isfinite(voxel_size_m)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the voxel size must be positive");
  }
  if (!(options.sheet_half_thickness_m >= 0.0) || !std::isfinite(options.sheet_half_thickness_m)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the half thickness of a sheet must not be negative");
  }
  if (mesh.triangles.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangles");
  const auto& progress = options.progress;
  const double half_thickness = options.sheet_half_thickness_m / voxel_size_m;
  Box box = BoundingBox(mesh);
  box.lower -= options.sheet_half_thickness_m;
  box.upper += options.sheet_half_thickness_m;
  DistanceField field;
  field.voxel_size_m = voxel_size_m;
  const double border = std::max<double>(DistanceField::kMinBorder, std::ceil(DistanceField::kBorder_m / voxel_size_m));
  const glm::dvec3 wanted = glm::ceil((box.upper - box.lower) / voxel_size_m) + 2.0 * border;
  if (!(wanted.x * wanted.y * wanted.z < kMaxFieldVoxels) || !(std::max({wanted.x, wanted.y, wanted.z}) < 1e6)) {
    return core::Fail(core::ErrorCode::kResource,
                      "a voxel size of " + std::to_string(voxel_size_m) +
                          " m is too small for this mesh: take a larger one, or check that the mesh is in metres");
  }
  const auto num_coarse = [&] { return wanted.x * wanted.y * wanted.z / std::pow(8.0, field.coarse_shift); };
  while (num_coarse() > static_cast<double>(kMaxCoarseCells) && field.coarse_shift < 6) ++field.coarse_shift;
  const int step = std::max(DistanceField::kBrick, 1 << field.coarse_shift);
  field.nx = RoundUp(static_cast<int>(wanted.x), step);
  field.ny = RoundUp(static_cast<int>(wanted.y), step);
  field.nz = RoundUp(static_cast<int>(wanted.z), step);
  field.origin_m = 0.5 * (box.lower + box.upper) - 0.5 * voxel_size_m * glm::dvec3(field.nx, field.ny, field.nz);

  TriangleMesh scaled = mesh;
  for (glm::dvec3& v : scaled.vertices) v = (v - field.origin_m) / voxel_size_m;
  const TriangleField triangles(scaled, half_thickness, options.sign_by_winding);
  if (triangles.num_triangles() == 0) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangle with an area");
  }
  if (progress) progress("distance field: raster", 0.0);
  const BandBricks band = RasterBand(triangles, glm::ivec3(field.nx, field.ny, field.nz) / DistanceField::kBrick,
                                     half_thickness + DistanceField::kBandVoxels);
  FillBricks(triangles, band, progress, &field);
  FitCreases(triangles, band, progress, &field);
  FillCoarse(triangles, progress, &field);
  if (progress) progress("distance field: coarse", 1.0);
  return field;
}

}  // namespace vps
