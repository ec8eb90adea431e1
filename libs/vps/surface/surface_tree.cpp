#include "vps/surface/surface_tree.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace vps {
namespace {

// a e e^T, in the order of SurfaceNode::spread_m4.
std::array<float, 6> Outer(float a, const glm::vec3& e) {
  return {a * e.x * e.x, a * e.y * e.y, a * e.z * e.z, a * e.x * e.y, a * e.x * e.z, a * e.y * e.z};
}

void Add(const std::array<float, 6>& from, std::array<float, 6>* to) {
  for (std::size_t i = 0; i < 6; ++i) (*to)[i] += from[i];
}

// Of |A| over a: below it the normals cancel. Not derived.
constexpr float kLeastDirection = 0.1f;

class Builder {
 public:
  explicit Builder(SurfaceTree* tree) : tree_(tree) {
    order_.resize(tree->triangles.size());
    for (std::uint32_t i = 0; i < order_.size(); ++i) {
      order_[i] = i;
      const auto& [a, b, c] = tree->triangles[i].corners;
      middles_.push_back((a + b + c) / 3.0f);
    }
  }

  void Build() { tree_->num_roots = Put(order_); }

 private:
  using Part = std::span<std::uint32_t>;

  // Appends the nodes of up to four parts of `all`, then theirs. Returns how many.
  std::uint32_t Put(Part all) {
    std::vector<Part> parts;
    Halve(all, 2, &parts);
    const auto first = static_cast<std::uint32_t>(tree_->nodes.size());
    const auto count = static_cast<std::uint32_t>(parts.size());
    tree_->nodes.resize(first + count);
    for (std::uint32_t i = 0; i < count; ++i) {
      SurfaceNode node;
      if (parts[i].size() == 1) {
        node = NodeOf(tree_->triangles[parts[i].front()]);
        node.first = parts[i].front();
      } else {
        const auto children = static_cast<std::uint32_t>(tree_->nodes.size());
        const std::uint32_t num_children = Put(parts[i]);
        node = Join(children, num_children);
        SetReach(parts[i], &node);
      }
      tree_->nodes[first + i] = node;
    }
    return count;
  }

  // In the middle of the widest side of their centroids' box, `times` times.
  void Halve(Part part, int times, std::vector<Part>* out) {
    if (part.empty()) return;
    if (times == 0 || part.size() == 1) {
      out->push_back(part);
      return;
    }
    glm::vec3 low = middles_[part.front()];
    glm::vec3 high = low;
    for (const std::uint32_t i : part) {
      low = glm::min(low, middles_[i]);
      high = glm::max(high, middles_[i]);
    }
    const glm::vec3 size = high - low;
    int axis = size.y > size.x ? 1 : 0;
    if (size.z > size[axis]) axis = 2;
    const std::size_t half = part.size() / 2;
    std::nth_element(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(half), part.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       return middles_[a][axis] != middles_[b][axis] ? middles_[a][axis] < middles_[b][axis] : a < b;
                     });
    Halve(part.first(half), times - 1, out);
    Halve(part.subspan(half), times - 1, out);
  }

  // With the children's moments about their own centroids c_i:
  //   c = sum a_i c_i / a,   N = sum N_i + A_i (c_i - c)^T,   Q = sum Q_i + a_i (c_i - c)(c_i - c)^T.
  [[nodiscard]] SurfaceNode Join(std::uint32_t first, std::uint32_t count) const {
    const std::span<const SurfaceNode> children(&tree_->nodes[first], count);
    SurfaceNode node;
    node.first = first;
    node.num_children = count;
    glm::dvec3 weighted(0.0);
    double area = 0.0;
    for (const SurfaceNode& child : children) {
      weighted += static_cast<double>(child.area_m2) * glm::dvec3(child.centre_m);
      area += static_cast<double>(child.area_m2);
    }
    node.area_m2 = static_cast<float>(area);
    node.centre_m = glm::vec3(weighted / area);
    for (const SurfaceNode& child : children) {
      const glm::vec3 e = child.centre_m - node.centre_m;
      node.area_vector_m2 += child.area_vector_m2;
      node.normal_moment_m3 += child.normal_moment_m3 + glm::outerProduct(child.area_vector_m2, e);
      Add(child.spread_m4, &node.spread_m4);
      Add(Outer(child.area_m2, e), &node.spread_m4);
    }
    return node;
  }

  void SetReach(Part part, SurfaceNode* node) const {
    for (const std::uint32_t i : part) {
      for (const glm::vec3& p : tree_->triangles[i].corners) {
        node->radius_m = std::max(node->radius_m, glm::length(p - node->centre_m));
      }
    }
    const float length = glm::length(node->area_vector_m2);
    if (!(length > kLeastDirection * node->area_m2)) {  // two sides that cancel: no direction
      node->thickness_m = node->radius_m;
      return;
    }
    FitCurvature(part, node->area_vector_m2 / length, node);
  }

  // K by least squares over the corners, in tangents u, v scaled by the radius:
  //   e . n = k0 + 1/2 (k1 u^2 + 2 k2 u v + k3 v^2).
  void FitCurvature(Part part, const glm::vec3& n, SurfaceNode* node) const {
    const glm::dvec3 axis = std::abs(n.x) < 0.6f ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 normal(n);
    const glm::dvec3 tangent = glm::normalize(glm::cross(normal, axis));
    const glm::dvec3 other = glm::cross(normal, tangent);
    const double scale = 1.0 / static_cast<double>(node->radius_m);
    const auto for_corners = [&](const auto& visit) {
      for (const std::uint32_t i : part) {
        for (const glm::vec3& p : tree_->triangles[i].corners) {
          const glm::dvec3 e = scale * glm::dvec3(p - node->centre_m);
          visit(glm::dot(e, tangent), glm::dot(e, other), glm::dot(e, normal));
        }
      }
    };
    glm::dmat4 sums(0.0);
    glm::dvec4 right(0.0);
    double count = 0.0;
    for_corners([&](double u, double v, double w) {
      const glm::dvec4 of(1.0, 0.5 * u * u, u * v, 0.5 * v * v);
      sums += glm::outerProduct(of, of);
      right += w * of;
      count += 1.0;
    });
    // A ridge, for corners in one line.
    constexpr double kRidge = 1e-8;
    for (int i = 1; i < 4; ++i) sums[i][i] += kRidge * count;
    const glm::dvec4 k = glm::inverse(sums) * right;
    const glm::dmat3 K = scale * (k[1] * glm::outerProduct(tangent, tangent) +
                                  k[2] * (glm::outerProduct(tangent, other) + glm::outerProduct(other, tangent)) +
                                  k[3] * glm::outerProduct(other, other));
    const std::array<double, 6> of = {K[0][0], K[1][1], K[2][2], K[1][0], K[2][0], K[2][1]};
    double mean = 0.0;  // tr(K Q) / 2 a, scaled
    for (std::size_t i = 0; i < 6; ++i) {
      node->curvature_per_m[i] = static_cast<float>(of[i]);
      mean += (i < 3 ? 0.5 : 1.0) * of[i] * static_cast<double>(node->spread_m4[i] / node->area_m2) * scale;
    }
    double most = 0.0;
    for_corners([&](double u, double v, double w) {
      most = std::max(most, std::abs(w + mean - 0.5 * (k[1] * u * u + 2.0 * k[2] * u * v + k[3] * v * v)));
    });
    node->thickness_m = static_cast<float>(most / scale);
  }

  SurfaceTree* tree_;
  std::vector<std::uint32_t> order_;
  std::vector<glm::vec3> middles_;
};

}  // namespace

// Over a triangle with corners c + v_i, sum of v_i = 0:  integral of e e^T = a / 12 sum of v_i v_i^T.
SurfaceNode NodeOf(const SurfacePiece& triangle) {
  const auto& [a, b, c] = triangle.corners;
  SurfaceNode node;
  node.centre_m = (a + b + c) / 3.0f;
  const glm::vec3 twice = glm::cross(c - a, b - a);
  node.area_vector_m2 = 0.5f * twice;
  node.area_m2 = 0.5f * glm::length(twice);
  for (const glm::vec3& corner : triangle.corners) {
    const glm::vec3 v = corner - node.centre_m;
    Add(Outer(node.area_m2 / 12.0f, v), &node.spread_m4);
    node.radius_m = std::max(node.radius_m, glm::length(v));
  }
  return node;
}

SurfaceFamily FamilyOf(std::span<const SurfaceNode> children) {
  SurfaceFamily family;
  for (std::size_t k = 0; k < kFamilySize; ++k) {
    const auto put = [&](int row, float value) { family.of[row][k] = value; };
    if (k >= children.size()) {  // at the place of the first, so that its search is no wider
      for (int i = 0; i < 3; ++i) put(kCentreRow + i, children[0].centre_m[i]);
      put(kIsFlatRow, 1.0f);
      continue;
    }
    const SurfaceNode& node = children[k];
    put(kRadiusRow, node.radius_m);
    put(kAreaRow, node.area_m2);
    for (int i = 0; i < 3; ++i) {
      put(kCentreRow + i, node.centre_m[i]);
      put(kAreaVectorRow + i, node.area_vector_m2[i]);
      for (int j = 0; j < 3; ++j) put(kNormalMomentRow + 3 * i + j, node.normal_moment_m3[i][j]);
    }
    for (int i = 0; i < 6; ++i) put(kSpreadRow + i, node.spread_m4[static_cast<std::size_t>(i)]);
    put(kIsFlatRow, node.num_children == 0 ? 1.0f : 0.0f);
    put(kThicknessRow, node.thickness_m);
    for (int i = 0; i < 6; ++i) put(kCurvatureRow + i, node.curvature_per_m[static_cast<std::size_t>(i)]);
    family.below[k] = node.first;
  }
  return family;
}

namespace {

// Breadth first, so that neighbours are side by side.
void PackFamilies(SurfaceTree* tree) {
  struct Run {
    std::uint32_t first, count;
  };
  std::vector<Run> runs = {{0, tree->num_roots}};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run run = runs[i];
    const auto nodes = std::span(tree->nodes).subspan(run.first, run.count);
    SurfaceFamily family = FamilyOf(nodes);
    for (std::size_t k = 0; k < run.count; ++k) {
      if (nodes[k].num_children == 0) continue;
      family.below[k] = static_cast<std::uint32_t>(runs.size());
      runs.push_back({nodes[k].first, nodes[k].num_children});
    }
    tree->families.push_back(family);
  }
}

}  // namespace

SurfaceTree BuildSurfaceTree(const TriangleMesh& mesh, double longest_m) {
  SurfaceTree tree;
  tree.triangles = CutIntoPieces(mesh, longest_m);
  Builder(&tree).Build();
  PackFamilies(&tree);
  for (std::uint32_t i = 0; i < tree.num_roots; ++i) tree.area_m2 += static_cast<double>(tree.nodes[i].area_m2);
  return tree;
}

}  // namespace vps
