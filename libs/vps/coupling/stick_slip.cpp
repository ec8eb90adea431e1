#include "vps/coupling/stick_slip.hpp"

#include <algorithm>
#include <cmath>

namespace vps {
namespace {

constexpr double kConvergence = 1e-5;  // of the largest force

// What a force changes in the motion along itself. Of the tangents the larger of the two eigenvalues: one factor for
// both directions keeps the force of a sliding contact opposite to its slip.
struct Compliance {
  double normal = 0.0;
  double tangent = 0.0;
};

Compliance ComplianceOf(const FrictionContact& c) {
  const double a = Dot(c.tangents[0], c.tangents[0]);
  const double b = Dot(c.tangents[1], c.tangents[1]);
  const double ab = Dot(c.tangents[0], c.tangents[1]);
  return {Dot(c.normal, c.normal), 0.5 * (a + b) + std::sqrt(0.25 * (a - b) * (a - b) + ab * ab)};
}

// Returns the largest change of a force.
double ImproveNormal(const Compliance& compliance, FrictionContact* c, Vector6* y) {
  const double wanted_N = c->normal_N + (c->bound - Dot(c->normal, *y)) / compliance.normal;
  const double change_N = std::clamp(wanted_N, 0.0, c->most_N) - c->normal_N;
  c->normal_N += change_N;
  AddScaled(change_N, c->normal, y);
  return std::abs(change_N);
}

double ImproveTangents(const Compliance& compliance, FrictionContact* c, Vector6* y) {
  std::array<double, 2> wanted_N;
  for (std::size_t k = 0; k < 2; ++k) {
    wanted_N[k] = c->tangent_N[k] - (c->slip_m[k] + Dot(c->tangents[k], *y)) / compliance.tangent;
  }
  const double length_N = std::sqrt(wanted_N[0] * wanted_N[0] + wanted_N[1] * wanted_N[1]);
  const double limit_N = c->friction * c->normal_N;
  const double factor = length_N > limit_N ? limit_N / length_N : 1.0;
  double largest_N = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    const double change_N = factor * wanted_N[k] - c->tangent_N[k];
    c->tangent_N[k] += change_N;
    AddScaled(change_N, c->tangents[k], y);
    largest_N = std::max(largest_N, std::abs(change_N));
  }
  return largest_N;
}

}  // namespace

// Projected Gauss-Seidel: contact by contact, the force that this contact alone would need is added and projected on
// its cone. At a fixed point all three conditions hold: the normal one is complementary; a tangential force inside the
// disc does not change, so slip + t . y = 0; one on its rim is the projection of itself less slip / compliance, so the
// slip points against it.
Vector6 SolveStickSlip(const Vector6& target, std::span<FrictionContact> contacts, int most_sweeps) noexcept {
  Vector6 y = target;
  for (FrictionContact& c : contacts) {
    c.normal_N = std::clamp(c.normal_N, 0.0, c.most_N);
    AddScaled(c.normal_N, c.normal, &y);
    for (std::size_t k = 0; k < 2; ++k) AddScaled(c.tangent_N[k], c.tangents[k], &y);
  }
  std::array<Compliance, kMaxFrictionContacts> compliances;
  for (std::size_t i = 0; i < contacts.size(); ++i) compliances[i] = ComplianceOf(contacts[i]);
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    double change_N = 0.0;
    double largest_N = 0.0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      change_N = std::max(change_N, ImproveNormal(compliances[i], &contacts[i], &y));
      change_N = std::max(change_N, ImproveTangents(compliances[i], &contacts[i], &y));
      largest_N = std::max(largest_N, contacts[i].normal_N);
    }
    if (change_N <= kConvergence * largest_N) break;
  }
  return y;
}

}  // namespace vps
