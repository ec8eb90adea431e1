#include "tools/oos/meshes/mesh_lines.hpp"

#include <cmath>
#include <cstdio>

#include "vps/mesh/part_size.hpp"

namespace oos {
namespace {

std::string Place(const glm::dvec3& p_m) {
  char text[80];
  std::snprintf(text, sizeof text, "(%.4g, %.4g, %.4g) m", p_m.x, p_m.y, p_m.z);
  return text;
}

}  // namespace

void PrintMesh(const std::string& file, const vps::MeshReport& report) {
  const glm::dvec3 size_m = report.box.upper - report.box.lower;
  std::printf("%s: %zu triangles, %.4g x %.4g x %.4g mm, %s%s\n", file.c_str(), report.num_triangles, 1e3 * size_m.x,
              1e3 * size_m.y, 1e3 * size_m.z, report.is_sheet ? "a sheet" : "a solid",
              report.num_parts > 1 ? (" of " + std::to_string(report.num_parts) + " parts").c_str() : "");
  for (const std::string& defect : vps::DescribeDefects(report)) std::printf("  mesh: %s\n", defect.c_str());
}

void PrintFeatures(const vps::FeatureSize& size) {
  if (std::isfinite(size.thickness_m)) {
    std::printf("  thinnest wall: %s at %s\n", vps::Millimetres(size.thickness_m).c_str(),
                Place(size.thinnest_m).c_str());
  }
  if (std::isfinite(size.gap_m)) {
    std::printf("  narrowest gap: %s at %s\n", vps::Millimetres(size.gap_m).c_str(), Place(size.narrowest_m).c_str());
  }
}

void PrintLimits(const vps::FeatureSize& size, const vps::FeatureLimits& limits) {
  std::printf("  shown: walls from %s, gaps from %s; a part passes untouched with %s to spare on each side\n",
              vps::Millimetres(limits.thickness_m).c_str(), vps::Millimetres(limits.gap_m).c_str(),
              vps::Millimetres(limits.clearance_m).c_str());
  if (size.thickness_m < limits.thickness_m) std::printf("  warning: its thinnest wall needs smaller voxels\n");
  if (size.gap_m < limits.gap_m) std::printf("  warning: its narrowest gap needs smaller voxels\n");
}

}  // namespace oos
