#include "vps/force/reduce_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "vps/force/direction_bins.hpp"

namespace vps {
namespace {

constexpr std::size_t kNumBins = kNumDirectionBins;
constexpr std::size_t kNumExtremes = 4;  // along +u, +v, -u, -v, which holds a flat face at its corners
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

struct Bin {
  std::uint32_t deepest = kNone;
  float penetration_m = -std::numeric_limits<float>::infinity();
  float preference_m = -std::numeric_limits<float>::infinity();  // penetration, with the bonus of the last cycle's
  glm::vec3 mean_normal_G{0.0f};
  glm::vec3 u_G{0.0f}, v_G{0.0f};  // tangents of the bin's own direction, so that they do not turn with the contacts
  std::array<std::uint32_t, kNumExtremes> extremes{};
  std::array<float, kNumExtremes> reach_m{};
  std::array<glm::vec3, 1 + kNumExtremes> previous_p_S;  // by slot; NaN: none

  Bin() { previous_p_S.fill(glm::vec3(std::numeric_limits<float>::quiet_NaN())); }
};

}  // namespace

void ReduceContacts(std::span<const SampledContact> contacts, const core::Pose& X_GS, double stiffness_N_per_m,
                    double band_m, ContactPlanes* planes, double hysteresis_m) {
  std::array<Bin, kNumBins> bins;
  for (const core::ContactPlane& plane : *planes) {
    if (plane.id / 8 < kNumBins && plane.id % 8 <= kNumExtremes) {
      bins[plane.id / 8].previous_p_S[plane.id % 8] = plane.p_S;
    }
  }
  planes->clear();
  if (contacts.empty()) return;
  const glm::mat3 R_GS(glm::mat3_cast(X_GS.rotation));
  const glm::vec3 p_GS(X_GS.translation);
  const auto band = static_cast<float>(band_m);
  const auto hysteresis = static_cast<float>(hysteresis_m);

  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    Bin& bin = bins[DirectionBin(R_GS * contacts[i].n_S)];
    bin.penetration_m = std::max(bin.penetration_m, contacts[i].penetration_m);
    const float preference = contacts[i].penetration_m + (contacts[i].p_S == bin.previous_p_S[0] ? hysteresis : 0.0f);
    if (preference > bin.preference_m) {
      bin.preference_m = preference;
      bin.deepest = i;
    }
  }

  for (std::size_t b = 0; b < kNumBins; ++b) {
    if (bins[b].deepest == kNone) continue;
    const Tangents tangents = BinTangents(b);
    bins[b].u_G = tangents.u;
    bins[b].v_G = tangents.v;
    bins[b].extremes.fill(kNone);
    bins[b].reach_m.fill(-std::numeric_limits<float>::infinity());
  }
  for (std::uint32_t i = 0; i < contacts.size(); ++i) {
    const glm::vec3 n_G = R_GS * contacts[i].n_S;
    Bin& bin = bins[DirectionBin(n_G)];
    const float nearness = contacts[i].penetration_m - (bin.penetration_m - band);
    if (nearness < 0.0f) continue;
    bin.mean_normal_G += (nearness + 1e-6f) * n_G;
    const glm::vec3 p_G = R_GS * contacts[i].p_S;
    const float u = glm::dot(p_G, bin.u_G);
    const float v = glm::dot(p_G, bin.v_G);
    const std::array<float, kNumExtremes> reach{u, v, -u, -v};
    for (std::size_t k = 0; k < kNumExtremes; ++k) {
      const float preference = reach[k] + (contacts[i].p_S == bin.previous_p_S[1 + k] ? 4.0f * hysteresis : 0.0f);
      if (preference > bin.reach_m[k]) {
        bin.reach_m[k] = preference;
        bin.extremes[k] = i;
      }
    }
  }

  std::array<std::size_t, kNumBins> order;
  std::size_t num_used = 0;
  for (std::size_t b = 0; b < kNumBins; ++b) {
    if (bins[b].deepest != kNone) order[num_used++] = b;
  }
  std::sort(order.begin(), order.begin() + num_used, [&](std::size_t a, std::size_t b) {
    return bins[a].penetration_m != bins[b].penetration_m ? bins[a].penetration_m > bins[b].penetration_m : a < b;
  });
  num_used = std::min(num_used, core::kMaxContactPlanes);

  std::size_t num_free = core::kMaxContactPlanes - num_used;  // beyond one for each bin
  for (std::size_t k = 0; k < num_used; ++k) {
    const Bin& bin = bins[order[k]];
    std::array<std::uint32_t, 1 + kNumExtremes> chosen{bin.deepest};
    std::array<std::uint32_t, 1 + kNumExtremes> slots{0};
    std::size_t num_chosen = 1;
    for (std::size_t e = 0; e < kNumExtremes && num_free > 0; ++e) {
      const std::uint32_t candidate = bin.extremes[e];
      if (std::find(chosen.begin(), chosen.begin() + num_chosen, candidate) != chosen.begin() + num_chosen) continue;
      chosen[num_chosen] = candidate;
      slots[num_chosen++] = static_cast<std::uint32_t>(1 + e);
      --num_free;
    }
    std::array<float, 1 + kNumExtremes> share{};
    float sum_of_shares = 0.0f;
    for (std::size_t c = 0; c < num_chosen; ++c) {
      share[c] = GuardShare(contacts[chosen[c]].penetration_m, band);
      sum_of_shares += share[c];
    }
    const float length = glm::length(bin.mean_normal_G);
    for (std::size_t c = 0; c < num_chosen; ++c) {
      const SampledContact& contact = contacts[chosen[c]];
      core::ContactPlane plane;
      plane.id = static_cast<std::uint32_t>(order[k] * 8) + slots[c];
      plane.p_S = contact.p_S;
      plane.n_G = length > 0.0f ? bin.mean_normal_G / length : R_GS * contact.n_S;
      // gap = n . (X_GS p_S - q) = -V(P), so the plane's point is the contact point moved by V along the normal.
      plane.q_G = R_GS * contact.p_S + p_GS + contact.penetration_m * plane.n_G;
      plane.stiffness_N_per_m = static_cast<float>(stiffness_N_per_m) * share[c] / sum_of_shares;
      planes->push_back(plane);
    }
  }
}

}  // namespace vps
