#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "vps/mesh/check_mesh.hpp"

namespace vps {
namespace {

std::string Text(const char* format, ...) {
  char text[200];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

std::string Places(const std::vector<MeshPlace>& places, std::size_t num_all) {
  constexpr std::size_t kShown = 3;  // fits a line of a terminal
  std::string text;
  for (std::size_t i = 0; i < places.size() && i < kShown; ++i) text += (i == 0 ? "" : "; ") + Describe(places[i]);
  return num_all > kShown ? text + "; ..." : text;
}

}  // namespace

std::string Describe(const MeshPlace& place) {
  const auto rounded = [](double x) { return std::abs(x) < 1e-12 ? 0.0 : x; };  // no "-0", no noise
  return Text("(%.5g, %.5g, %.5g) m, triangle %u", rounded(place.p_m.x), rounded(place.p_m.y), rounded(place.p_m.z),
              place.triangle);
}

std::vector<std::string> DescribeDefects(const MeshReport& r) {
  std::vector<std::string> lines;
  if (r.num_zero_area > 0) lines.push_back(Text("%zu triangles without area ignored", r.num_zero_area));
  if (r.num_doubled > 0) lines.push_back(Text("%zu doubled triangles dropped", r.num_doubled));
  if (r.num_welded_near > 0) {
    lines.push_back(
        Text("%zu corners at cracks welded (less than %.1g of the size apart)", r.num_welded_near, kWeldRatio));
  }
  if (r.num_splits > 0)
    lines.push_back(Text("%zu corners lay on edges of others, which were split there", r.num_splits));
  if (r.num_triangles_turned > 0) {
    lines.push_back(Text("%zu triangles of %zu part(s) faced the wrong way and were turned: at ",
                         r.num_triangles_turned, r.num_parts_turned) +
                    Places(r.turned, r.num_triangles_turned));
  }
  if (r.num_conflicts > 0) {
    lines.push_back(
        Text("%zu triangles cannot be oriented consistently with all their neighbours: at ", r.num_conflicts) +
        Places(r.conflicts, r.num_conflicts));
  }
  if (r.num_many_sided_edges > 0) {
    lines.push_back(Text("%zu edges have more than two triangles: at ", r.num_many_sided_edges) +
                    Places(r.many_sided_edges, r.num_many_sided_edges));
  }
  if (r.num_open_edges > 0) {
    std::string line = Text("%zu open edges around %zu holes%s: ", r.num_open_edges, r.num_holes,
                            r.is_sheet ? "" : ", closed by lids");
    for (std::size_t i = 0; i < r.holes.size() && i < 3; ++i) {
      line += (i == 0 ? "" : "; ") + Text("%zu edges, %.4g m long at ", r.holes[i].num_edges, r.holes[i].length_m) +
              Describe(r.holes[i].place);
    }
    lines.push_back(r.num_holes > 3 ? line + "; ..." : line);
  }
  if (r.num_loose > 0) lines.push_back(Text("%zu loose triangles dropped", r.num_loose));
  if (r.num_crossings > 0) {
    lines.push_back(Text("%s%zu pairs of triangles pass through each other: at ",
                         r.num_crossings >= MeshReport::kMaxCrossings ? "at least " : "", r.num_crossings) +
                    Places(r.crossings, r.num_crossings));
  }
  return lines;
}

}  // namespace vps
