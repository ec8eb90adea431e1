#include "vps/coupling/nearest_point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vps {
namespace {

constexpr double kTolerance_m = 1e-11;  // of a half-space: rounding of a metre, with a factor of 1e5 to spare
// A half-space that cannot be met beside the others ends the search when it is missed by more. A micrometre is below
// all that is shown, and far above what rounding makes of half-spaces that nearly depend on each other.
constexpr double kContradiction_m = 1e-6;
// Of its part outside the others' span, squared. One that lies nearer counts as dependent on them: to meet it, too,
// they would press against each other a thousand times as hard as something presses on them.
constexpr double kIndependence = 1e-6;
// Each half-space is taken up and dropped a few times at most; a bound against endless turns.
constexpr int kMostSteps = 8 * int{kMaxHalfSpaces};

// Normals of the active half-spaces, N = Q R with orthonormal Q and upper triangular R.
class ActiveSet {
 public:
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t operator[](std::size_t k) const { return indices_[k]; }
  [[nodiscard]] bool Holds(std::size_t index) const {
    return std::find(indices_.begin(), indices_.begin() + size_, index) != indices_.begin() + size_;
  }

  // a = N r + z with z orthogonal to all of N. The part along Q is taken off twice, because rounding leaves some of it
  // after the first time when a lies almost in the span.
  void Split(const Vector6& a, Vector6* r, Vector6* z) const {
    Vector6 along{};
    *z = a;
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t k = 0; k < size_; ++k) {
        const double part = Dot(q_[k], *z);
        along[k] += part;
        AddScaled(-part, q_[k], z);
      }
    }
    for (std::size_t k = size_; k-- > 0;) {
      double sum = along[k];
      for (std::size_t j = k + 1; j < size_; ++j) sum -= r_[k][j] * (*r)[j];
      (*r)[k] = sum / r_[k][k];
    }
  }
  void Add(std::size_t index, const Vector6& a) {
    Vector6& q = q_[size_];
    q = a;
    for (std::size_t k = 0; k < size_; ++k) r_[k][size_] = 0.0;
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t k = 0; k < size_; ++k) {
        const double part = Dot(q_[k], q);
        r_[k][size_] += part;
        AddScaled(-part, q_[k], &q);
      }
    }
    const double norm = std::sqrt(Dot(q, q));
    r_[size_][size_] = norm;
    for (double& x : q) x /= norm;
    indices_[size_++] = index;
  }
  void Drop(std::size_t k, const HalfSpaces& half_spaces) {
    const std::size_t old_size = size_;
    size_ = k;
    for (std::size_t j = k + 1; j < old_size; ++j) Add(indices_[j], half_spaces.of[indices_[j]].a);
  }

  // u with N^T (target + N u) = b.
  void Solve(const Vector6& target, const HalfSpaces& half_spaces, Vector6* u) const {
    for (std::size_t k = 0; k < size_; ++k) {
      const HalfSpace& h = half_spaces.of[indices_[k]];
      double sum = h.b - Dot(h.a, target);
      for (std::size_t j = 0; j < k; ++j) sum -= r_[j][k] * (*u)[j];
      (*u)[k] = sum / r_[k][k];
    }
    for (std::size_t k = size_; k-- > 0;) {
      for (std::size_t j = k + 1; j < size_; ++j) (*u)[k] -= r_[k][j] * (*u)[j];
      (*u)[k] /= r_[k][k];
    }
  }

 private:
  std::size_t size_ = 0;
  std::array<std::size_t, 6> indices_{};
  std::array<Vector6, 6> q_{};
  std::array<Vector6, 6> r_{};
};

// Starts with the half-spaces that were active in the last cycle, less those that would pull.
void StartFromLastCycle(const Vector6& target, const HalfSpaces& half_spaces, ActiveSet* active, NearestPoint* result) {
  for (std::size_t i = 0; i < half_spaces.count && active->size() < 6; ++i) {
    const HalfSpace& h = half_spaces.of[i];
    if (!h.was_active || h.is_left_out) continue;
    Vector6 r{};
    Vector6 z;
    active->Split(h.a, &r, &z);
    if (Dot(z, z) > kIndependence * Dot(h.a, h.a)) active->Add(i, h.a);
  }
  Vector6 u{};
  while (active->size() > 0) {
    active->Solve(target, half_spaces, &u);
    const auto least = std::min_element(u.begin(), u.begin() + active->size());
    if (*least >= 0.0) break;
    active->Drop(static_cast<std::size_t>(least - u.begin()), half_spaces);
  }
  for (std::size_t k = 0; k < active->size(); ++k) {
    result->multipliers[(*active)[k]] = u[k];
    AddScaled(u[k], half_spaces.of[(*active)[k]].a, &result->y);
  }
}

}  // namespace

// The dual active-set method of Goldfarb and Idnani (1983) with the unit matrix as Hessian. y is always the solution
// for the half-spaces of the active set N: y = target + N u, u >= 0. A violated half-space p enters: with
//   a_p = N r + z,  z orthogonal to N,
// the step  y += t z,  u -= t r,  u_p += t  keeps y the solution of a problem in which p's bound grows from a_p . y to
// b_p; d(a_p . y)/dt = a_p . z = |z|^2. It ends at the smaller of
//   t_2 = (b_p - a_p . y) / |z|^2   where p is satisfied: it becomes active, and
//   t_1 = min u_j / r_j over r_j > 0  where j stops to push: it leaves, and the step goes on.
// Each p that is added raises the minimum, so no active set comes twice and the method ends. It may start from any N
// with u >= 0. If z is next to nothing and no r_j > 0, then a_p is about N r with r <= 0: no point near satisfies p and
// N together. Up to a micrometre p is left as it is then; beyond, there is no solution.
void ProjectOntoHalfSpaces(const Vector6& target, const HalfSpaces& half_spaces, NearestPoint* result) noexcept {
  result->y = target;
  result->worst_violation = 0.0;
  std::fill_n(result->multipliers.begin(), half_spaces.count, 0.0);
  std::array<bool, kMaxHalfSpaces> is_contradicting{};
  std::array<double, kMaxHalfSpaces>& u = result->multipliers;
  ActiveSet active;
  Vector6& y = result->y;
  StartFromLastCycle(target, half_spaces, &active, result);
  for (int steps_left = kMostSteps; steps_left > 0;) {
    std::size_t p = half_spaces.count;
    double most = kTolerance_m;
    for (std::size_t i = 0; i < half_spaces.count; ++i) {
      const HalfSpace& h = half_spaces.of[i];
      const double lack = h.b - Dot(h.a, y);
      if (lack <= most || h.is_left_out || is_contradicting[i] || active.Holds(i)) continue;
      most = lack;
      p = i;
    }
    if (p == half_spaces.count) return;
    const Vector6& a = half_spaces.of[p].a;
    double lack = half_spaces.of[p].b - Dot(a, y);
    for (; steps_left > 0; --steps_left) {
      Vector6 r{};
      Vector6 z;
      active.Split(a, &r, &z);
      const double zz = Dot(z, z);
      const bool is_independent = active.size() < 6 && zz > kIndependence * Dot(a, a);
      const double to_satisfy = is_independent ? lack / zz : std::numeric_limits<double>::infinity();
      double step = to_satisfy;
      std::size_t leaving = active.size();
      for (std::size_t j = 0; j < active.size(); ++j) {
        if (r[j] <= 0.0 || u[active[j]] >= step * r[j]) continue;
        step = u[active[j]] / r[j];
        leaving = j;
      }
      if (!is_independent && leaving == active.size()) {
        is_contradicting[p] = true;
        result->worst_violation = std::max(result->worst_violation, lack);
        if (lack > kContradiction_m) return;
        break;
      }
      for (std::size_t j = 0; j < active.size(); ++j) u[active[j]] = std::max(u[active[j]] - step * r[j], 0.0);
      u[p] += step;
      AddScaled(step, z, &y);
      lack -= step * zz;
      if (leaving == active.size()) {
        active.Add(p, a);
        --steps_left;
        break;
      }
      u[active[leaving]] = 0.0;
      active.Drop(leaving, half_spaces);
    }
  }
}

}  // namespace vps
