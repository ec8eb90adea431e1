#include "vps/oracle/contact_wrench.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace vps::oracle {
namespace {

// Dunavant 1985, degree 4: two orbits of three points, barycentric (1 - 2 b, b, b); weights add up to one.
constexpr double kOrbit[2] = {0.445948490915965, 0.091576213509771};
constexpr double kWeight[2] = {0.223381589678011, 0.109951743655322};

struct Estimate {
  double depth = 0.0;      // integral of depth dA
  glm::dvec3 moment{0.0};  // integral of depth (x - B's origin) dA
  bool has_depth = false;
  Estimate& operator+=(const Estimate& other) {
    depth += other.depth;
    moment += other.moment;
    has_depth = has_depth || other.has_depth;
    return *this;
  }
};

enum class Side { kOutside, kInside, kCrossing };

struct Piece {
  Triangle t;
  glm::dvec3 inward{0.0};
  Side side = Side::kCrossing;
  Estimate coarse;
  Estimate fine;  // sum of the four children's coarse estimates
  std::array<Estimate, 4> child_estimates;
  std::array<Side, 4> child_sides{};
  double error = 0.0;
};

glm::dvec3 Centroid(const Triangle& t) {
  return (t[0] + t[1] + t[2]) / 3.0;
}

double Radius(const Triangle& t, const glm::dvec3& c) {
  return std::max({glm::distance(c, t[0]), glm::distance(c, t[1]), glm::distance(c, t[2])});
}

double Area(const Triangle& t) {
  return 0.5 * glm::length(glm::cross(t[1] - t[0], t[2] - t[0]));
}

// Halves the longest edge, and that of each half, so that pieces do not become or stay slivers.
std::array<Triangle, 2> Halve(const Triangle& t) {
  int k = 0;  // the corner opposite the longest edge
  for (int i = 1; i < 3; ++i) {
    const auto edge = [&](int corner) { return glm::distance(t[(corner + 1) % 3], t[(corner + 2) % 3]); };
    if (edge(i) > edge(k)) k = i;
  }
  const glm::dvec3 middle = 0.5 * (t[(k + 1) % 3] + t[(k + 2) % 3]);
  return {{{t[k], t[(k + 1) % 3], middle}, {t[k], middle, t[(k + 2) % 3]}}};
}

std::array<Triangle, 4> Split(const Triangle& t) {
  const std::array<Triangle, 2> halves = Halve(t);
  const std::array<Triangle, 2> a = Halve(halves[0]);
  const std::array<Triangle, 2> b = Halve(halves[1]);
  return {{a[0], a[1], b[0], b[1]}};
}

class Integrator {
 public:
  Integrator(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB) : A_(A), B_(B), X_AB_(X_AB) {
    for (const Triangle& t : B.triangles()) {
      for (const glm::dvec3& v : t) arm_ = std::max(arm_, glm::length(v));
      scale_ += Area(t) * B.nodes()[0].radius_m;
    }
  }

  ContactWrench Run(const WrenchAccuracy& accuracy) {
    if (B_.triangles().empty() || !A_.has_inside()) return {};
    Collect(0);
    ContactWrench wrench;
    const double floor = accuracy.floor * scale_;
    while (true) {
      wrench = Sum();
      const double goal = accuracy.relative * std::max(glm::length(wrench.force_A_m3), 1e-2 * wrench.depth_integral_m3);
      if (wrench.error_bound_m3 <= goal || wrench.error_bound_m3 <= floor) break;
      if (pieces_.size() >= accuracy.max_pieces) {
        wrench.has_converged = false;
        break;
      }
      Refine(std::max(goal, floor));
    }
    wrench.num_samples = num_samples_;
    return wrench;
  }

 private:
  // Walks B's tree: a group whose sphere does not reach A's surface lies wholly inside or outside.
  void Collect(std::uint32_t index) {
    const MeshDistance::Node& node = B_.nodes()[index];
    const glm::dvec3 c = X_AB_ * node.centre_m;
    const double d = A_.SignedDistance(c);
    if (std::abs(d) > node.radius_m * (1.0 + 1e-12)) {
      if (d < 0.0) {
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) Add(InA(i), Side::kInside);
      }
      return;
    }
    if (node.left != 0) {
      Collect(node.left);
      Collect(node.left + 1);
      return;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const Triangle t = InA(i);
      if (const Side side = Classify(t); side != Side::kOutside) Add(t, side);
    }
  }

  Triangle InA(std::uint32_t i) const {
    const Triangle& t = B_.triangles()[i];
    return {X_AB_ * t[0], X_AB_ * t[1], X_AB_ * t[2]};
  }

  Side Classify(const Triangle& t) const {
    const glm::dvec3 c = Centroid(t);
    const double d = A_.SignedDistance(c);
    if (std::abs(d) <= Radius(t, c) * (1.0 + 1e-12) && A_.Meets(t)) return Side::kCrossing;
    return d < 0.0 ? Side::kInside : Side::kOutside;
  }

  void Add(const Triangle& t, Side side) {
    const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
    const double length = glm::length(n);
    if (length <= 0.0) return;
    Piece piece;
    piece.t = t;
    piece.inward = -n / length;
    piece.side = side;
    piece.coarse = Sample(t, side);
    Complete(&piece);
    pieces_.push_back(piece);
  }

  // Samples the four children and estimates the piece's error: the change from its own estimate to the sum of theirs.
  void Complete(Piece* piece) {
    piece->fine = {};
    const std::array<Triangle, 4> children = Split(piece->t);
    for (int k = 0; k < 4; ++k) {
      piece->child_sides[k] = piece->side == Side::kCrossing ? Classify(children[k]) : piece->side;
      piece->child_estimates[k] = Sample(children[k], piece->child_sides[k]);
      piece->fine += piece->child_estimates[k];
    }
    const glm::dvec3 moment_change = piece->fine.moment - piece->coarse.moment;
    piece->error = std::max(std::abs(piece->fine.depth - piece->coarse.depth), glm::length(moment_change) / arm_);
    // A surface may cut off a corner between the samples. Their spacing is about a quarter of the radius, so that the
    // part is no deeper than that and a fraction of the area; 1 / 50 of area times radius is not derived further.
    if (piece->side == Side::kCrossing && !piece->fine.has_depth) {
      piece->error = std::max(piece->error, Area(piece->t) * Radius(piece->t, Centroid(piece->t)) / 50.0);
    }
  }

  Estimate Sample(const Triangle& t, Side side) {
    Estimate sum;
    if (side == Side::kOutside) return sum;
    const double area = Area(t);
    for (int orbit = 0; orbit < 2; ++orbit) {
      const double b = kOrbit[orbit];
      for (int k = 0; k < 3; ++k) {
        const glm::dvec3 x = (1.0 - 2.0 * b) * t[k] + b * (t[(k + 1) % 3] + t[(k + 2) % 3]);
        const double depth = side == Side::kInside ? A_.UnsignedDistance(x) : -A_.SignedDistance(x);
        ++num_samples_;
        if (depth <= 0.0) continue;
        sum.has_depth = true;
        sum.depth += kWeight[orbit] * area * depth;
        sum.moment += kWeight[orbit] * area * depth * (x - X_AB_.translation);
      }
    }
    return sum;
  }

  ContactWrench Sum() const {
    ContactWrench wrench;
    for (const Piece& piece : pieces_) {
      wrench.force_A_m3 += piece.fine.depth * piece.inward;
      wrench.moment_A_m4 += glm::cross(piece.fine.moment, piece.inward);
      wrench.depth_integral_m3 += piece.fine.depth;
      wrench.error_bound_m3 += piece.error;
      if (piece.fine.has_depth) {
        wrench.area_m2 += Area(piece.t);
        ++wrench.num_pieces_with_depth;
      }
    }
    return wrench;
  }

  // Keeps the pieces with the smallest errors, together worth half the goal, and splits the others.
  void Refine(double goal) {
    std::vector<std::uint32_t> order(pieces_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      return pieces_[a].error != pieces_[b].error ? pieces_[a].error < pieces_[b].error : a < b;
    });
    std::vector<Piece> next;
    next.reserve(2 * pieces_.size());
    double kept = 0.0;
    std::size_t i = 0;
    while (i < order.size() && kept + pieces_[order[i]].error <= 0.5 * goal) {
      kept += pieces_[order[i]].error;
      next.push_back(pieces_[order[i++]]);
    }
    for (; i < order.size(); ++i) {
      const Piece& parent = pieces_[order[i]];
      const std::array<Triangle, 4> children = Split(parent.t);
      for (int k = 0; k < 4; ++k) {
        if (parent.child_sides[k] == Side::kOutside) continue;
        Piece child;
        child.t = children[k];
        child.inward = parent.inward;
        child.side = parent.child_sides[k];
        child.coarse = parent.child_estimates[k];
        Complete(&child);
        next.push_back(child);
      }
    }
    pieces_ = std::move(next);
  }

  const MeshDistance& A_;
  const MeshDistance& B_;
  const core::Pose X_AB_;
  double arm_ = 1e-300;  // greatest distance of B's surface from its origin
  double scale_ = 0.0;   // B's area times its radius
  std::vector<Piece> pieces_;
  std::uint64_t num_samples_ = 0;
};

}  // namespace

ContactWrench IntegrateContactWrench(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB,
                                     const WrenchAccuracy& accuracy) {
  return Integrator(A, B, X_AB).Run(accuracy);
}

}  // namespace vps::oracle
