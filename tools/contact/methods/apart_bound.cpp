#include "tools/contact/methods/apart_bound.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "vps/mesh/nearest_on_triangle.hpp"

namespace contact {
namespace {

using Triangle = BoxTree::Triangle;

// Against the rounding of axes and half sides to floats, as a share of a length; some 6e-8 each.
constexpr double kPad = 1e-6;

glm::dvec3 MiddleOf(const Triangle& t) {
  return (t[0] + t[1] + t[2]) / 3.0;
}

// Unit, about the eigenvectors of a symmetric matrix: each product with it turns a vector towards the largest one. Any
// axes bound a part; good ones bound it closely.
glm::dvec3 LargestAxis(glm::dmat3 m) {
  constexpr int kSquarings = 6;  // m^64; not derived
  for (int i = 0; i < kSquarings; ++i) {
    const double size = std::max({m[0][0], m[1][1], m[2][2]});  // the largest entry of a matrix that is not negative
    if (!(size > 0.0)) return {1.0, 0.0, 0.0};
    m /= size;
    m = m * m;
  }
  int k = 0;
  for (int i = 1; i < 3; ++i) {
    if (glm::dot(m[i], m[i]) > glm::dot(m[k], m[k])) k = i;
  }
  return glm::normalize(m[k]);
}

// The longest axis, and across it that of the largest extent.
glm::mat3 MainAxes(std::span<const Triangle> part) {
  glm::dvec3 sum(0.0);
  for (const Triangle& t : part) sum += t[0] + t[1] + t[2];
  const glm::dvec3 mean = sum / (3.0 * static_cast<double>(part.size()));
  glm::dmat3 spread(0.0);
  for (const Triangle& t : part) {
    for (const glm::dvec3& p : t) spread += glm::outerProduct(p - mean, p - mean);
  }
  const glm::dvec3 a = LargestAxis(spread);
  const glm::dmat3 across = glm::dmat3(1.0) - glm::outerProduct(a, a);
  const glm::dvec3 rest = LargestAxis(across * spread * across);
  const glm::dvec3 other = std::abs(a.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 flat = rest - glm::dot(a, rest) * a;
  const glm::dvec3 b = glm::normalize(glm::dot(flat, flat) > 0.5 ? flat : glm::cross(a, other));
  return {glm::vec3(a), glm::vec3(b), glm::vec3(glm::cross(a, b))};
}

double AreaOf(const glm::dvec3& sides) {
  return sides.x * sides.y + sides.y * sides.z + sides.z * sides.x;
}

// Along three axes.
struct Extent {
  glm::dvec3 low{std::numeric_limits<double>::infinity()};
  glm::dvec3 high{-std::numeric_limits<double>::infinity()};
  void Add(const glm::dvec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  [[nodiscard]] double Area() const { return AreaOf(high - low); }
};

BoxTree::Node BoxAround(std::span<const Triangle> part) {
  BoxTree::Node node;
  node.axes = MainAxes(part);
  const glm::dmat3 to_axes = glm::transpose(glm::dmat3(node.axes));
  glm::dvec3 low(1e300);
  glm::dvec3 high(-1e300);
  for (const Triangle& t : part) {
    for (const glm::dvec3& p : t) {
      low = glm::min(low, to_axes * p);
      high = glm::max(high, to_axes * p);
    }
  }
  node.centre_m = glm::vec3(glm::dmat3(node.axes) * (0.5 * (low + high)));
  glm::dvec3 half(0.0);
  for (const Triangle& t : part) {
    for (const glm::dvec3& p : t) half = glm::max(half, glm::abs(to_axes * (p - glm::dvec3(node.centre_m))));
  }
  node.half_sides_m = glm::vec3(half + kPad * glm::length(half));
  return node;
}

// Where along an axis of the box the areas of both boxes, each times its number of triangles, add up to least; in equal
// numbers if all middles are in one place. (Of slices of a whole part, each with something of every face, the boxes are
// large and hold little.)
std::size_t Halve(const BoxTree::Node& box, std::span<Triangle> part) {
  constexpr int kBins = 16;  // not derived
  struct Bin {
    Extent extent;
    double count = 0.0;
    void Add(const Bin& other) {
      extent.low = glm::min(extent.low, other.extent.low);
      extent.high = glm::max(extent.high, other.extent.high);
      count += other.count;
    }
    [[nodiscard]] double Cost() const { return count > 0.0 ? count * extent.Area() : 0.0; }
  };
  const glm::dmat3 axes(box.axes);
  Extent middles;
  for (const Triangle& t : part) middles.Add(MiddleOf(t) * axes);
  const glm::dvec3 per_bin = static_cast<double>(kBins) / (middles.high - middles.low);
  const auto bin_of = [&](const Triangle& t, int k) {
    const double at = ((MiddleOf(t) * axes)[k] - middles.low[k]) * per_bin[k];
    return at > 0.0 ? std::min(static_cast<int>(std::min(at, 1.0 * kBins)), kBins - 1) : 0;  // 0 also if not a number
  };
  std::array<std::array<Bin, kBins>, 3> bins;
  for (const Triangle& t : part) {
    Bin one{{}, 1.0};
    for (const glm::dvec3& p : t) one.extent.Add(p * axes);
    for (int k = 0; k < 3; ++k) bins[k][bin_of(t, k)].Add(one);
  }
  double least = std::numeric_limits<double>::infinity();
  int axis = 0;
  int first_of_second = 0;
  for (int k = 0; k < 3; ++k) {
    std::array<double, kBins> before{};  // cost of the bins below
    Bin sum;
    for (int i = 0; i + 1 < kBins; ++i) {
      sum.Add(bins[k][i]);
      before[i + 1] = sum.Cost();
    }
    sum = {};
    for (int i = kBins - 1; i > 0; --i) {
      sum.Add(bins[k][i]);
      const double cost = before[i] + sum.Cost();
      const bool is_split = sum.count > 0.0 && sum.count < static_cast<double>(part.size());
      if (!is_split || cost >= least) continue;
      least = cost;
      axis = k;
      first_of_second = i;
    }
  }
  const auto second =
      std::partition(part.begin(), part.end(), [&](const Triangle& t) { return bin_of(t, axis) < first_of_second; });
  const auto half = static_cast<std::size_t>(second - part.begin());
  return half == 0 || half == part.size() ? part.size() / 2 : half;
}

// One of each part that triangles connect by corners they share.
std::vector<glm::dvec3> CornersOfParts(const vps::TriangleMesh& mesh) {
  std::vector<std::uint32_t> above(mesh.vertices.size());
  std::iota(above.begin(), above.end(), 0U);
  const auto find = [&](std::uint32_t v) {
    while (above[v] != v) v = above[v] = above[above[v]];
    return v;
  };
  for (const auto& t : mesh.triangles) {
    above[find(t[1])] = find(t[0]);
    above[find(t[2])] = find(t[0]);
  }
  std::vector<glm::dvec3> corners;
  std::vector<bool> is_known(mesh.vertices.size(), false);
  for (const auto& t : mesh.triangles) {
    const std::uint32_t part = find(t[0]);
    if (!is_known[part]) corners.push_back(mesh.vertices[t[0]]);
    is_known[part] = true;
  }
  return corners;
}

struct Part {
  std::uint32_t node;
  std::size_t begin, end;  // triangles
};

// The nearest places of two segments a + s u and b + t v, s and t in [0, 1] (Ericson 2005, 5.1.9).
void NearestOnSegments(const glm::dvec3& a, const glm::dvec3& u, const glm::dvec3& b, const glm::dvec3& v,
                       glm::dvec3* on_a, glm::dvec3* on_b) {
  const glm::dvec3 r = a - b;
  const double uu = glm::dot(u, u);
  const double vv = glm::dot(v, v);
  const double uv = glm::dot(u, v);
  const double ur = glm::dot(u, r);
  const double vr = glm::dot(v, r);
  const double across = uu * vv - uv * uv;
  double s = across > 0.0 ? std::clamp((uv * vr - ur * vv) / across, 0.0, 1.0) : 0.0;
  const double t = std::clamp(vv > 0.0 ? (uv * s + vr) / vv : 0.0, 0.0, 1.0);
  s = std::clamp(uu > 0.0 ? (uv * t - ur) / uu : 0.0, 0.0, 1.0);
  *on_a = a + s * u;
  *on_b = b + t * v;
}

// Nearest places of two triangles that do not meet: of a corner of one and the other, or of two edges. Returns from the
// one on T to that on S.
glm::dvec3 Between(const Triangle& S, const Triangle& T) {
  glm::dvec3 best(0.0);
  double least = std::numeric_limits<double>::infinity();
  const auto offer = [&](const glm::dvec3& way) {
    if (glm::dot(way, way) >= least) return;
    least = glm::dot(way, way);
    best = way;
  };
  const auto from_corners = [&](const Triangle& corners, const Triangle& other, double sign) {
    const glm::dvec3 n = glm::cross(other[1] - other[0], other[2] - other[0]);
    for (const glm::dvec3& p : corners) {
      offer(-sign * vps::NearestOnTriangle(other[0] - p, other[1] - p, other[2] - p, n).place);
    }
  };
  from_corners(S, T, 1.0);
  from_corners(T, S, -1.0);
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      glm::dvec3 on_S;
      glm::dvec3 on_T;
      NearestOnSegments(S[i], S[(i + 1) % 3] - S[i], T[k], T[(k + 1) % 3] - T[k], &on_S, &on_T);
      offer(on_S - on_T);
    }
  }
  return best;
}

}  // namespace

BoxTree::BoxTree(const vps::TriangleMesh& mesh) {
  triangles.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = mesh.corners(i);
    // Without area its sides are its neighbours'.
    if (glm::length(glm::cross(t[1] - t[0], t[2] - t[0])) > 0.0) triangles.push_back(t);
  }
  if (triangles.empty()) return;
  nodes.reserve(2 * triangles.size());
  nodes.emplace_back();
  std::vector<Part> parts = {{0, 0, triangles.size()}};
  while (!parts.empty()) {
    const Part part = parts.back();
    parts.pop_back();
    const std::span<Triangle> all = std::span(triangles).subspan(part.begin, part.end - part.begin);
    Node node = BoxAround(all);
    if (all.size() == 1) {
      node.below = Node::kLeaf | static_cast<std::uint32_t>(part.begin);
    } else {
      node.below = static_cast<std::uint32_t>(nodes.size());
      nodes.resize(nodes.size() + 2);
      const std::size_t middle = part.begin + Halve(node, all);
      parts.push_back({node.below, part.begin, middle});
      parts.push_back({node.below + 1, middle, part.end});
    }
    nodes[part.node] = node;
  }
}

// What a node holds, in G's frame: a box, or of a leaf its triangle.
class ApartBound::Body {
 public:
  Body(const BoxTree& tree, std::uint32_t node) : is_triangle_(tree.nodes[node].is_leaf()) {
    const BoxTree::Node& box = tree.nodes[node];
    if (is_triangle_) {
      const Triangle& t = tree.triangles[box.first()];
      of_ = glm::dmat3(t[0], t[1], t[2]);
      centre_m_ = MiddleOf(t);
    } else {
      of_ = glm::dmat3(box.axes);
      centre_m_ = glm::dvec3(box.centre_m);
      half_sides_m_ = glm::dvec3(box.half_sides_m);
    }
  }
  Body(const glm::dmat3& R_GS, const glm::dvec3& p_GS, const BoxTree& tree, std::uint32_t node) : Body(tree, node) {
    of_ = R_GS * of_;
    centre_m_ = R_GS * centre_m_ + p_GS;
    if (!is_triangle_) return;
    for (int i = 0; i < 3; ++i) of_[i] += p_GS;
  }

  [[nodiscard]] const glm::dvec3& middle_m() const { return centre_m_; }
  [[nodiscard]] Triangle corners() const { return {of_[0], of_[1], of_[2]}; }
  // Its place that is nearest to p.
  [[nodiscard]] glm::dvec3 Nearest(const glm::dvec3& p) const {
    if (!is_triangle_) return centre_m_ + of_ * glm::clamp((p - centre_m_) * of_, -half_sides_m_, half_sides_m_);
    const glm::dvec3 n = glm::cross(of_[1] - of_[0], of_[2] - of_[0]);
    return p + vps::NearestOnTriangle(of_[0] - p, of_[1] - p, of_[2] - p, n).place;
  }
  // The greatest product of a place with u.
  [[nodiscard]] double Reach(const glm::dvec3& u) const {
    const glm::dvec3 along = u * of_;
    if (is_triangle_) return std::max({along.x, along.y, along.z});
    return glm::dot(u, centre_m_) + glm::dot(glm::abs(along), half_sides_m_);
  }

 private:
  bool is_triangle_;
  glm::dmat3 of_;  // columns: axes of the box, or corners of the triangle [m]
  glm::dvec3 centre_m_{0.0}, half_sides_m_{0.0};
};

ApartBound::ApartBound(const vps::TriangleMesh& G, const vps::TriangleMesh& S)
    : G_(G), S_(S), corners_of_S_m_(CornersOfParts(S)) {}

// Along the way between a place of G and the nearest one of S to it. Nearer places, found in turns, give better bounds,
// but open hardly fewer pairs.
void ApartBound::Offer(const Body& body_S, const Body& body_G, Pair pair) {
  const glm::dvec3 on_G = body_G.Nearest(body_S.middle_m());
  const glm::dvec3 way = body_S.Nearest(on_G) - on_G;
  const double distance_m = glm::length(way);
  if (distance_m > pair.bound_m) {  // else the bound cannot be greater either
    const glm::dvec3 u = way / distance_m;
    pair.bound_m = std::max(pair.bound_m, -body_S.Reach(-u) - body_G.Reach(u));
  }
  if (pair.bound_m >= enough_m()) {
    least_m_ = std::min(least_m_, pair.bound_m);
    return;
  }
  heap_.push_back(pair);
  std::push_heap(heap_.begin(), heap_.end());
}

void ApartBound::MeetTriangles(const Triangle& S, const Triangle& G, const Pair& pair) {
  const glm::dvec3 way = Between(S, G);
  const double distance_m = glm::length(way);
  if (distance_m < nearest_m_) {
    nearest_m_ = distance_m;
    last_ = pair;
  }
  // Along the way between their nearest places their extents are apart by just that, unless they meet.
  double gap_m = 0.0;
  if (distance_m > 0.0) {
    const glm::dvec3 u = way / distance_m;
    gap_m = std::min({glm::dot(u, S[0]), glm::dot(u, S[1]), glm::dot(u, S[2])}) -
            std::max({glm::dot(u, G[0]), glm::dot(u, G[1]), glm::dot(u, G[2])});
  }
  least_m_ = std::min(least_m_, gap_m);
}

double ApartBound::Query_m(const core::Pose& X_GS) {
  if (S_.nodes.empty() || G_.nodes.empty()) return 0.0;
  const glm::dmat3 R_GS = glm::mat3_cast(X_GS.rotation);
  const auto of_S = [&](std::uint32_t node) { return Body(R_GS, X_GS.translation, S_, node); };
  const auto of_G = [&](std::uint32_t node) { return Body(G_, node); };
  heap_.clear();
  nearest_m_ = least_m_ = std::numeric_limits<double>::infinity();
  if (S_.nodes[last_.s].is_leaf() && G_.nodes[last_.g].is_leaf()) {
    MeetTriangles(of_S(last_.s).corners(), of_G(last_.g).corners(), last_);
  }
  Offer(of_S(0), of_G(0), {});
  for (int n = 0; !heap_.empty(); ++n) {
    std::pop_heap(heap_.begin(), heap_.end());
    const Pair pair = heap_.back();
    heap_.pop_back();
    if (pair.bound_m >= std::min(enough_m(), least_m_) || n == kMostPairs) {
      least_m_ = std::min(least_m_, pair.bound_m);
      break;
    }
    const Body body_S = of_S(pair.s);
    const Body body_G = of_G(pair.g);
    const BoxTree::Node& s = S_.nodes[pair.s];
    const BoxTree::Node& g = G_.nodes[pair.g];
    const auto size = [](const BoxTree::Node& node) { return AreaOf(node.half_sides_m); };
    if (s.is_leaf() && g.is_leaf()) {
      MeetTriangles(body_S.corners(), body_G.corners(), pair);
    } else if (g.is_leaf() || (!s.is_leaf() && size(s) > size(g))) {
      for (const std::uint32_t child : {s.first(), s.first() + 1})
        Offer(of_S(child), body_G, {pair.bound_m, child, pair.g});
    } else {
      for (const std::uint32_t child : {g.first(), g.first() + 1})
        Offer(body_S, of_G(child), {pair.bound_m, pair.s, child});
    }
  }
  return std::max(0.0, (1.0 - kPad) * least_m_);
}

}  // namespace contact
