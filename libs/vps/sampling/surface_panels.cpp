#include "vps/sampling/surface_panels.hpp"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

#include "vps/sampling/sliver.hpp"

namespace vps {
namespace {

constexpr double kSlice = 4.0;  // a slice no longer than so many of its heights is not cut further; not derived

// Cuts triangles and calls take(panel) for each panel.
template <class Take>
class Cutter {
 public:
  Cutter(const SampleSpacing& spacing, double size, const Take& take) : spacing_(spacing), size_(size), take_(take) {}

  void Cut(const std::array<glm::dvec3, 3>& corners) {
    const auto& [a, b, c] = corners;
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double length = glm::length(n);
    if (!(length > 0.0)) return;
    normal_ = n / length;
    const Box box{glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
    const Sliver sliver(corners);
    if (sliver.is_thin()) {
      CutAcross(sliver, 0.0, sliver.length_m(), spacing_.Around(box));
    } else {
      Divide(corners, spacing_.Around(box));
    }
  }

 private:
  void Divide(const std::array<glm::dvec3, 3>& corners, const SampleSpacing::Nearby& nearby) const {
    const auto& [a, b, c] = corners;
    const glm::dvec3 centroid = (a + b + c) / 3.0;
    const double radius = std::max({glm::length(a - centroid), glm::length(b - centroid), glm::length(c - centroid)});
    const double sides[3] = {glm::length(b - a), glm::length(c - b), glm::length(a - c)};
    const int k = static_cast<int>(std::max_element(sides, sides + 3) - sides);
    const SampleSpacing::Distances distances = spacing_.To(centroid, nearby, radius);
    if (sides[k] <= size_ * spacing_.At(distances, radius)) {
      take_({centroid, normal_, 0.5 * glm::length(glm::cross(b - a, c - a)), radius, spacing_.At(distances)});
      return;
    }
    const glm::dvec3 from = corners[k];
    const glm::dvec3 to = corners[(k + 1) % 3];
    const glm::dvec3 opposite = corners[(k + 2) % 3];
    const glm::dvec3 middle = 0.5 * (from + to);
    const auto divide = [&](const SampleSpacing::Nearby& narrow) {
      Divide({from, middle, opposite}, narrow);
      Divide({middle, to, opposite}, narrow);
    };
    if (nearby.is_empty()) {
      divide(nearby);
    } else {
      divide(spacing_.Narrow(nearby, centroid, radius, distances));
    }
  }

  void CutAcross(const Sliver& sliver, double x0, double x1, const SampleSpacing::Nearby& nearby) const {
    const std::vector<glm::dvec3> corners = sliver.Slice(x0, x1);
    glm::dvec3 middle(0.0);
    for (const glm::dvec3& p : corners) middle += p / static_cast<double>(corners.size());
    double radius = 0.0;
    for (const glm::dvec3& p : corners) radius = std::max(radius, glm::length(p - middle));
    const bool is_stocky = x1 - x0 <= kSlice * sliver.HeightBetween(x0, x1);
    const SampleSpacing::Distances distances = spacing_.To(middle, nearby, radius);
    if (is_stocky || 2.0 * radius <= size_ * spacing_.At(distances, radius)) {
      for (std::size_t i = 2; i < corners.size(); ++i) {
        Divide({corners[0], corners[i - 1], corners[i]}, nearby);
      }
      return;
    }
    const SampleSpacing::Nearby narrow = spacing_.Narrow(nearby, middle, radius, distances);
    CutAcross(sliver, x0, 0.5 * (x0 + x1), narrow);
    CutAcross(sliver, 0.5 * (x0 + x1), x1, narrow);
  }

  const SampleSpacing& spacing_;
  double size_;
  const Take& take_;
  glm::dvec3 normal_{0.0};  // of the triangle
};

constexpr std::size_t kTrianglesOfBlock = 16;  // free: enough blocks for all workers, whatever the mesh

template <class Take>
void ForPanels(const TriangleMesh& mesh, std::size_t block, const SampleSpacing& spacing, double size,
               const Take& take) {
  Cutter<Take> cutter(spacing, size, take);
  const std::size_t end = std::min((block + 1) * kTrianglesOfBlock, mesh.triangles.size());
  for (std::size_t t = block * kTrianglesOfBlock; t < end; ++t) cutter.Cut(mesh.corners(t));
}

}  // namespace

PanelCount CountPanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size, std::size_t most_kept,
                       core::ParallelFor* workers) {
  const std::size_t num_blocks = (mesh.triangles.size() + kTrianglesOfBlock - 1) / kTrianglesOfBlock;
  PanelCount out;
  out.begins.assign(num_blocks + 1, 0);
  out.kept.resize(num_blocks);
  std::atomic<std::size_t> room = most_kept;
  core::ForEach(workers, num_blocks, [&](std::size_t block) {
    std::vector<SurfacePanel> panels;
    std::size_t count = 0;
    ForPanels(mesh, block, spacing, size, [&](const SurfacePanel& panel) {
      if (++count <= most_kept) panels.push_back(panel);
    });
    out.begins[block + 1] = count;
    std::size_t left = room.load(std::memory_order_relaxed);
    while (count <= left && !room.compare_exchange_weak(left, left - count, std::memory_order_relaxed)) {
    }
    if (count <= left) out.kept[block].assign(panels.begin(), panels.end());  // of its own size
  });
  std::partial_sum(out.begins.begin(), out.begins.end(), out.begins.begin());
  return out;
}

std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size,
                                     PanelCount count, core::ParallelFor* workers) {
  std::vector<SurfacePanel> panels(count.begins.back());
  core::ForEach(workers, count.kept.size(), [&](std::size_t block) {
    std::size_t at = count.begins[block];
    if (count.kept[block].empty()) {
      ForPanels(mesh, block, spacing, size, [&](const SurfacePanel& panel) { panels[at++] = panel; });
    } else {
      std::copy(count.kept[block].begin(), count.kept[block].end(), panels.begin() + static_cast<std::ptrdiff_t>(at));
    }
  });
  return panels;
}

std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size) {
  return MakePanels(mesh, spacing, size, CountPanels(mesh, spacing, size));
}

}  // namespace vps
