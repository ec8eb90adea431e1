#include "vps/coupling/stick_slip.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace vps {
namespace {

constexpr double k = kContactStiffness_N_per_m;
// Bounds of the search, each with room to spare: StickSlip.* fail with one turn, with 12 steps and with 10 trials, and
// pass with two turns; 10, 100 and 100 fail nowhere and cost time where contacts contradict each other.
constexpr int kMostTurns = 3;    // of the cone's law
constexpr int kMostSteps = 25;   // of Newton's method
constexpr int kMostTrials = 40;  // of a step's length
// Of the largest rise, and of each limit: friction is wanted within 3 % of the cone. From 1e-4 to 0.1 every test
// passes; smaller takes more turns.
constexpr double kSettled = 1e-2;
// A step is long enough when the slope there is only so much of the one at its beginning. At 0.9 steps are too short
// for kMostSteps (StickSlip.HoldsCoulombsLaw*), 0.05 passes and takes more trials.
constexpr double kLevel = 0.3;
// The energy that a step can still gain: of the spring's, or what moves a tool on 1 kN/m by less than 1e-12 m.
constexpr double kConverged = 1e-18;
constexpr double kConverged_J = 1e-22;
constexpr double kRounding = 1e-12;  // of F

using Matrix6 = std::array<Vector6, 6>;

// The lower half of m.
void AddOuter(double factor, const Vector6& row, Matrix6* m) {
  for (std::size_t i = 0; i < 6; ++i) {
    const double scaled = factor * row[i];
    for (std::size_t j = 0; j <= i; ++j) (*m)[i][j] += scaled * row[j];
  }
}

// m = L L^T, with L in its lower half. m is at least the unit matrix.
void Factor(Matrix6* m) {
  for (std::size_t j = 0; j < 6; ++j) {
    for (std::size_t i = j; i < 6; ++i) {
      double sum = (*m)[i][j];
      for (std::size_t l = 0; l < j; ++l) sum -= (*m)[i][l] * (*m)[j][l];
      (*m)[i][j] = i == j ? std::sqrt(std::max(sum, 1.0)) : sum / (*m)[j][j];
    }
  }
}

Vector6 Solved(const Matrix6& lower, Vector6 b) {
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < i; ++j) b[i] -= lower[i][j] * b[j];
    b[i] /= lower[i][i];
  }
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t j = i + 1; j < 6; ++j) b[i] -= lower[j][i] * b[j];
    b[i] /= lower[i][i];
  }
  return b;
}

double Norm(const std::array<double, 2>& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1]);
}
double Norm(const Vector6& v) {
  return std::sqrt(Dot(v, v));
}

// A contact at r = bound - normal . y and s = slip + tangents . y: what it takes from F, and its forces.
struct State {
  double r_m;
  std::array<double, 2> s_m;
  double length_m;  // |s|
};

// The two laws of contact forces, by their potentials in F(y) = 1/2 |y - target|^2 + sum of both over the contacts.
// kLimit, with the limit L of each force along a plane as given:
//   P(r) = k r^2 / 2 for r > 0, and most (r - most / 2 k) where k r > most;
//   Q(s) = k s^2 / 2 for |s| < L / k, and L (|s| - L / 2 k) beyond:
// the forces -P' and -Q' are of springs of stiffness k that give way at `most` and L. This is Coulomb's law where
// L = mu P'.
// kCone: the force is the point of the cone |t| <= mu n that is nearest to k (r, -s),
//   R(r, s) = k (r^2 + s^2) / 2 where |s| <= mu r; k (r + mu |s|)^2 / (2 + 2 mu^2) beyond; 0 where r + mu |s| <= 0.
// This has Coulomb's forces, without a limit to be known before, but what slips also rises by mu |s| (Anitescu 2006).
// With `rise_m` taken off r for each that slips by |s| = rise_m / mu, it is Coulomb's law (Cadoux 2009).
// A contact that fades out keeps the law of its limit.
enum class Law { kLimit, kCone };

// F is convex, so that y is its only minimum. Newton's method with a search along each step: F is quadratic but where
// contacts change. A step that is a little too long can raise it where contacts change early on it; what has not fallen
// in the end is given up (Minimum). So what the spring to the target gives is at most what the contacts take, however
// early the search ends.
class Potential {
 public:
  Potential(Law law, const Vector6& target, std::span<Contact> contacts)
      : law_(law), target_(target), contacts_(contacts) {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const Contact& c = contacts[i];
      if (!HasTangents(c)) continue;
      lever_[i] = std::sqrt(Dot(c.tangents[0], c.tangents[0]) + Dot(c.tangents[1], c.tangents[1]));
      slip_m_[i] = Norm(c.slip_m);
    }
  }

  // Newton's step from y, and what F would gain by half of it.
  double Step(const Vector6& y, Vector6* step) const {
    Vector6 g = y;
    AddScaled(-1.0, target_, &g);
    Matrix6 H{};
    for (std::size_t i = 0; i < 6; ++i) H[i][i] = 1.0;
    const double length = Norm(y);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const Contact& c = contacts_[i];
      const State state = StateAt(i, y, length);
      if (IsOnCone(c)) {
        AddCone(c, state, &g, &H);
      } else {
        AddNormal(c, state, &g, &H);
        if (c.limit_N > 0.0) AddTangents(c, state, &g, &H);
      }
    }
    Factor(&H);
    for (std::size_t i = 0; i < 6; ++i) (*step)[i] = -g[i];
    *step = Solved(H, *step);
    return -Dot(g, *step);
  }

  // How much of the step F falls along.
  double Length(const Vector6& y, const Vector6& step) const {
    Line line = Along(y, step);
    const double begin = Slope(line, 0.0);
    double low = 0.0, high = 1.0, at_low = begin, at_high = Slope(line, 1.0);
    if (at_high <= -kLevel * begin) return 1.0;
    for (int trial = 0; trial < kMostTrials && high - low > 1e-9 * high; ++trial) {
      // In turns: where a straight line through both ends is level, and the middle.
      const double level = low - at_low * (high - low) / (at_high - at_low);
      const double middle = trial % 2 == 0 ? level : 0.5 * (low + high);
      const double slope = Slope(line, middle);
      if (std::abs(slope) <= -kLevel * begin) return middle;
      (slope < 0.0 ? low : high) = middle;
      (slope < 0.0 ? at_low : at_high) = slope;
    }
    return low;
  }

  [[nodiscard]] double Spring_J(const Vector6& y) const {
    Vector6 from_target = y;
    AddScaled(-1.0, target_, &from_target);
    return 0.5 * Dot(from_target, from_target);
  }
  [[nodiscard]] double F_J(const Vector6& y) const {
    double sum_J = Spring_J(y);
    const double length = Norm(y);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const Contact& c = contacts_[i];
      const State state = StateAt(i, y, length);
      if (IsOnCone(c)) {
        const auto [n, t] = ConeForce(c, state);
        sum_J += 0.5 * (n * n + t * t) / k;
      } else {
        sum_J += Given_J(std::max(state.r_m, 0.0), c.most_N) + Given_J(state.length_m, c.limit_N);
      }
    }
    return sum_J;
  }

  // Puts the forces at y into the contacts.
  void TakeForces(const Vector6& y) const {
    const double length = Norm(y);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      Contact& c = contacts_[i];
      const State state = StateAt(i, y, length);
      double along_N = 0.0;
      if (IsOnCone(c)) {
        std::tie(c.normal_N, along_N) = ConeForce(c, state);
      } else {
        c.normal_N = std::clamp(k * state.r_m, 0.0, c.most_N);
        along_N = std::min(k * state.length_m, c.limit_N);
      }
      const double factor = along_N > 0.0 ? -along_N / state.length_m : 0.0;
      c.tangent_N = {factor * state.s_m[0], factor * state.s_m[1]};
    }
  }

 private:
  // What a step does to the contacts that it can touch.
  struct Line {
    double slope = 0.0, curvature = 0.0;  // of the spring
    std::size_t count = 0;
    std::array<std::size_t, kMaxHalfSpaces> index;
    std::array<State, kMaxHalfSpaces> begin, step;
  };

  [[nodiscard]] bool IsOnCone(const Contact& c) const {
    return law_ == Law::kCone && c.most_N == std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] bool HasTangents(const Contact& c) const { return IsOnCone(c) ? c.friction > 0.0 : c.limit_N > 0.0; }
  // `length` is that of y. Without the slip of what cannot touch even if that were as large as y allows.
  [[nodiscard]] State StateAt(std::size_t i, const Vector6& y, double length) const {
    const Contact& c = contacts_[i];
    State state{c.bound - Dot(c.normal, y), {}, 0.0};
    if (!HasTangents(c)) return state;
    if (IsOnCone(c)) {
      state.r_m -= c.rise_m;
      if (state.r_m + c.friction * (slip_m_[i] + lever_[i] * length) <= 0.0) return state;
    }
    state.s_m = {c.slip_m[0] + Dot(c.tangents[0], y), c.slip_m[1] + Dot(c.tangents[1], y)};
    state.length_m = Norm(state.s_m);
    return state;
  }

  // P or Q.
  static double Given_J(double r_m, double most_N) {
    return k * r_m < most_N ? 0.5 * k * r_m * r_m : most_N * (r_m - 0.5 * most_N / k);
  }
  // Along the normal, and against the slip.
  static std::pair<double, double> ConeForce(const Contact& c, const State& state) {
    const double mu = c.friction;
    if (state.length_m <= mu * state.r_m) return {k * state.r_m, k * state.length_m};
    const double n = std::max(k / (1.0 + mu * mu) * (state.r_m + mu * state.length_m), 0.0);
    return {n, mu * n};
  }

  static void AddNormal(const Contact& c, const State& state, Vector6* g, Matrix6* H) {
    const double force_N = k * state.r_m;
    if (force_N < 0.0) return;
    AddScaled(-std::min(force_N, c.most_N), c.normal, g);
    if (force_N < c.most_N) AddOuter(k, c.normal, H);
  }
  // A force along the plane of size t: H gets Q'' = k where it sticks; where it slips, it only turns: t / |s| across.
  static void AddTangents(const Contact& c, const State& state, Vector6* g, Matrix6* H) {
    const bool sticks = k * state.length_m <= c.limit_N;
    if (sticks) {
      AddSticking(c, state, g, H);
      return;
    }
    const double stiffness = c.limit_N / state.length_m;
    for (std::size_t t = 0; t < 2; ++t) AddScaled(stiffness * state.s_m[t], c.tangents[t], g);
    AddOuter(stiffness, Across(c, state), H);
  }
  static void AddSticking(const Contact& c, const State& state, Vector6* g, Matrix6* H) {
    for (std::size_t t = 0; t < 2; ++t) {
      AddScaled(k * state.s_m[t], c.tangents[t], g);
      AddOuter(k, c.tangents[t], H);
    }
  }
  static Vector6 Across(const Contact& c, const State& state) {
    Vector6 across{};
    AddScaled(-state.s_m[1] / state.length_m, c.tangents[0], &across);
    AddScaled(state.s_m[0] / state.length_m, c.tangents[1], &across);
    return across;
  }
  // On the cone's side R' is n along v, the derivative of r + mu |s|.
  static void AddCone(const Contact& c, const State& state, Vector6* g, Matrix6* H) {
    const double mu = c.friction;
    if (state.length_m <= mu * state.r_m) {
      AddScaled(-k * state.r_m, c.normal, g);
      AddOuter(k, c.normal, H);
      if (mu > 0.0) AddSticking(c, state, g, H);
      return;
    }
    const double n = k / (1.0 + mu * mu) * (state.r_m + mu * state.length_m);
    if (!(n >= 0.0)) return;
    Vector6 v{};
    AddScaled(-1.0, c.normal, &v);
    if (mu > 0.0) {
      for (std::size_t t = 0; t < 2; ++t) AddScaled(mu * state.s_m[t] / state.length_m, c.tangents[t], &v);
      AddOuter(mu * n / state.length_m, Across(c, state), H);
    }
    AddScaled(n, v, g);
    AddOuter(k / (1.0 + mu * mu), v, H);
  }

  [[nodiscard]] Line Along(const Vector6& y, const Vector6& step) const {
    Line line;
    Vector6 from_target = y;
    AddScaled(-1.0, target_, &from_target);
    line.slope = Dot(from_target, step);
    line.curvature = Dot(step, step);
    const double longest = Norm(y) + Norm(step);
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const Contact& c = contacts_[i];
      State& begin = line.begin[line.count];
      State& along = line.step[line.count];
      begin = StateAt(i, y, longest);
      along = {-Dot(c.normal, step), {}, 0.0};
      const bool can_stick = HasTangents(c) && !IsOnCone(c);
      const double rise_m = HasTangents(c) ? c.friction * (slip_m_[i] + lever_[i] * longest) : 0.0;
      if (!can_stick && std::max(begin.r_m, begin.r_m + along.r_m) + rise_m <= 0.0) continue;
      if (HasTangents(c)) along.s_m = {Dot(c.tangents[0], step), Dot(c.tangents[1], step)};
      line.index[line.count++] = i;
    }
    return line;
  }

  [[nodiscard]] double Slope(const Line& line, double share) const {
    double slope = line.slope + share * line.curvature;
    for (std::size_t l = 0; l < line.count; ++l) {
      const Contact& c = contacts_[line.index[l]];
      const State& step = line.step[l];
      State state{line.begin[l].r_m + share * step.r_m, {}, 0.0};
      const bool has_tangents = HasTangents(c);
      if (has_tangents) {
        for (std::size_t t = 0; t < 2; ++t) state.s_m[t] = line.begin[l].s_m[t] + share * step.s_m[t];
        state.length_m = Norm(state.s_m);
      }
      double normal_N = 0.0, along_N = 0.0;
      if (IsOnCone(c)) {
        std::tie(normal_N, along_N) = ConeForce(c, state);
      } else {
        normal_N = std::clamp(k * state.r_m, 0.0, c.most_N);
        along_N = std::min(k * state.length_m, c.limit_N);
      }
      slope += normal_N * step.r_m;
      if (!has_tangents || !(along_N > 0.0)) continue;
      slope += along_N / state.length_m * (state.s_m[0] * step.s_m[0] + state.s_m[1] * step.s_m[1]);
    }
    return slope;
  }

  Law law_;
  const Vector6& target_;
  std::span<Contact> contacts_;
  // |slip + tangents . y| is at most slip_m_ + lever_ |y|.
  std::array<double, kMaxHalfSpaces> slip_m_, lever_;
};

Vector6 Minimum(Law law, const Vector6& target, const Vector6& start, const Vector6& guess,
                std::span<Contact> contacts) {
  const Potential potential(law, target, contacts);
  const double at_guess_J = potential.F_J(guess), at_start_J = potential.F_J(start);
  const Vector6 first = at_guess_J < at_start_J ? guess : start;
  const double first_J = std::min(at_guess_J, at_start_J);
  Vector6 y = first;
  for (int i = 0; i < kMostSteps; ++i) {
    Vector6 step;
    const double gain_J = potential.Step(y, &step);
    if (!(gain_J > kConverged * potential.Spring_J(y) + kConverged_J)) break;
    AddScaled(potential.Length(y, step), step, &y);
  }
  if (potential.F_J(y) > (1.0 + kRounding) * first_J) y = first;
  potential.TakeForces(y);
  return y;
}

// Lets each contact that slips at y rise by mu |s| less. True when that is about what it was.
bool TakeRises(const Vector6& y, std::span<Contact> contacts) {
  double change_m = 0.0, largest_m = 0.0;
  for (Contact& c : contacts) {
    if (c.friction == 0.0) continue;
    const std::array<double, 2> slip{c.slip_m[0] + Dot(c.tangents[0], y), c.slip_m[1] + Dot(c.tangents[1], y)};
    const double slip_m = Norm(slip);
    const bool slips = k * slip_m > c.friction * c.normal_N;
    const double rise_m = slips ? c.friction * slip_m : 0.0;
    change_m = std::max(change_m, std::abs(rise_m - c.rise_m));
    largest_m = std::max(largest_m, rise_m);
    c.rise_m = rise_m;
  }
  return change_m <= kSettled * largest_m;
}

// With the limits as they are: what sticks is inside its cone, and what slips is on it.
bool HoldsCoulombsLaw(std::span<const Contact> contacts) {
  return std::all_of(contacts.begin(), contacts.end(), [](const Contact& c) {
    const double cone_N = c.friction * c.normal_N;
    const double along_N = Norm(c.tangent_N);
    if (along_N < (1.0 - kSettled) * c.limit_N) return along_N <= cone_N;
    return std::abs(c.limit_N - cone_N) <= kSettled * cone_N;
  });
}

}  // namespace

// In most cycles the limits of the last one hold. Else the cone's law has the normal forces, in turns with the rises,
// and the limits that they allow have the way. It begins with what slips under the old limits: of all forces by which a
// tight hole can hold a tool it finds those that are least. Where nothing has moved y = 0 is right.
Vector6 SolveStickSlip(const Vector6& target, const Vector6& start, std::span<Contact> contacts) noexcept {
  Vector6 y = Minimum(Law::kLimit, target, start, {}, contacts);
  if (HoldsCoulombsLaw(contacts)) return y;
  for (int turn = 0; turn < kMostTurns; ++turn) {
    if (TakeRises(y, contacts) && turn > 0) break;
    y = Minimum(Law::kCone, target, start, y, contacts);
  }
  for (Contact& c : contacts) c.limit_N = c.friction * c.normal_N;
  return Minimum(Law::kLimit, target, start, y, contacts);
}

Vector6 SolveStickSlipWithLimits(const Vector6& target, const Vector6& start, std::span<Contact> contacts) noexcept {
  return Minimum(Law::kLimit, target, start, {}, contacts);
}

}  // namespace vps
