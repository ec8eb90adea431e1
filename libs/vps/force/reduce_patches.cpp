#include "vps/force/reduce_patches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "vps/force/direction_bins.hpp"

namespace vps {
namespace {

constexpr std::size_t kMaxPlanes = core::kMaxContactPlanes;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr float kLeastShare = 0.05f;  // of the stiffness, of a guard far away

// Slots of a bin's planes: id = 16 bin + slot.
constexpr std::uint32_t kSlots = 16;
constexpr std::uint32_t kNumQuarters = 4;  // slots 0 to 3: load; bit 0: u > 0, bit 1: v > 0, when cut that way
constexpr std::uint32_t kFirstGuard = 4;   // nearest, then the four that lie farthest out
constexpr std::size_t kNumGuards = 5;

// Sums over patches in contact.
struct Sums {
  glm::dvec3 force{0.0}, moment{0.0}, place{0.0};  // place times volume
  double volume = 0.0, square = 0.0;

  void Add(const ContactPatch& patch) {
    force += glm::dvec3(patch.force_m3);
    moment += glm::dvec3(patch.moment_m4);
    place += static_cast<double>(patch.volume_m3) * glm::dvec3(patch.p_S);
    volume += patch.volume_m3;
    square += patch.square_m4;
  }
};

struct Bin {
  float deepest_m = -kFar;
  Tangents tangents;
  // Load.
  float load = 0.0f, sum_u = 0.0f, sum_v = 0.0f, sum_uu = 0.0f, sum_vv = 0.0f;  // weighted with volume
  bool is_cut_u = false, is_cut_v = false;
  bool was_cut_u = false, was_cut_v = false;
  std::array<Sums, kNumQuarters> quarters;
  // Guards.
  glm::vec3 mean_normal_G{0.0f};
  std::array<std::uint32_t, kNumGuards> guards;
  std::array<float, kNumGuards> preference;
  std::array<glm::vec3, kNumGuards> previous_p_S;  // NaN: none

  Bin() {
    guards.fill(kNone);
    preference.fill(-kFar);
    previous_p_S.fill(glm::vec3(std::numeric_limits<float>::quiet_NaN()));
  }
  [[nodiscard]] std::uint32_t quarter(const glm::vec3& p_G) const {
    const bool is_u = is_cut_u && glm::dot(p_G, tangents.u) * load > sum_u;
    const bool is_v = is_cut_v && glm::dot(p_G, tangents.v) * load > sum_v;
    return (is_u ? 1U : 0U) | (is_v ? 2U : 0U);
  }
  [[nodiscard]] std::size_t num_cuts() const { return (is_cut_u ? 2U : 1U) * (is_cut_v ? 2U : 1U) - 1U; }
};

// A force at a place.
struct Carrier {
  std::uint32_t id = 0;
  glm::dvec3 force{0.0}, place{0.0};
  double depth_m = 0.0;
};

// Of a gathering: its force along the unit n, at the place on the axis next to the middle, p = c + f x (m - c x f) /
// f^2; the middle itself where forces cancel and the axis lies far away.
Carrier Gather(std::uint32_t id, const Sums& sums, const glm::dvec3& n, double reach_m) {
  Carrier carrier{id, glm::dot(sums.force, n) * n, sums.place / sums.volume, sums.square / sums.volume};
  const glm::dvec3 rest = sums.moment - glm::cross(carrier.place, sums.force);
  const glm::dvec3 shift = glm::cross(carrier.force, rest) / glm::dot(carrier.force, carrier.force);
  if (glm::length(shift) < reach_m) carrier.place += shift;
  return carrier;
}

// Changes the forces by little so that they add up to the load.
void Balance(const ContactLoad& load, std::span<Carrier> carriers) {
  double total = 0.0;
  for (const Carrier& c : carriers) total += glm::length(c.force);
  if (!(total > 0.0)) return;
  glm::dvec3 mean(0.0);
  glm::dvec3 force = load.force_m3;
  for (const Carrier& c : carriers) {
    mean += glm::length(c.force) / total * c.place;
    force -= c.force;
  }
  glm::dvec3 moment = load.moment_m4 - glm::cross(mean, load.force_m3);
  glm::dmat3 inertia(0.0);
  for (const Carrier& c : carriers) {
    const glm::dvec3 r = c.place - mean;
    moment -= glm::cross(r, c.force);
    inertia += glm::length(c.force) / total * (glm::dot(r, r) * glm::dmat3(1.0) - glm::outerProduct(r, r));
  }
  const double size = inertia[0][0] + inertia[1][1] + inertia[2][2];
  glm::dvec3 turn(0.0);
  if (size > 0.0) turn = glm::inverse(inertia + 1e-6 * size * glm::dmat3(1.0)) * moment;
  // By at most a quarter of the forces: a moment that places so close together cannot carry is left.
  double most = 0.0;
  for (const Carrier& c : carriers) most = std::max(most, glm::length(glm::cross(turn, c.place - mean)) / total);
  if (most > 0.25) turn *= 0.25 / most;
  for (Carrier& c : carriers) {
    c.force += glm::length(c.force) / total * (force + glm::cross(turn, c.place - mean));
  }
}

float GuardShare(float penetration_m, float band_m) {
  return std::clamp(1.0f + penetration_m / (0.25f * band_m + 1e-9f), kLeastShare, 1.0f);
}

}  // namespace

void ReducePatches(std::span<const ContactPatch> patches, const core::Pose& X_GS, const ContactLoad& load,
                   double stiffness_N_per_m, double band_m, double width_m, ContactPlanes* planes,
                   double hysteresis_m) {
  std::array<Bin, kNumDirectionBins> bins;
  for (const core::ContactPlane& plane : *planes) {
    Bin& bin = bins[std::min<std::size_t>(plane.id / kSlots, kNumDirectionBins - 1)];
    const std::uint32_t slot = plane.id % kSlots;
    if (slot < kNumQuarters) {
      bin.was_cut_u = bin.was_cut_u || (slot & 1U) != 0;
      bin.was_cut_v = bin.was_cut_v || (slot & 2U) != 0;
    } else if (slot < kFirstGuard + kNumGuards) {
      bin.previous_p_S[slot - kFirstGuard] = plane.p_S;
    }
  }
  planes->clear();
  if (patches.empty()) return;
  const glm::mat3 R_GS(glm::mat3_cast(X_GS.rotation));
  const glm::vec3 p_GS(X_GS.translation);
  const auto band = static_cast<float>(band_m);
  const auto hysteresis = static_cast<float>(hysteresis_m);

  for (std::size_t b = 0; b < kNumDirectionBins; ++b) bins[b].tangents = BinTangents(b == 13 ? 0 : b);
  double total_volume = 0.0;
  for (const ContactPatch& patch : patches) {
    Bin& bin = bins[DirectionBin(R_GS * patch.n_S)];
    bin.deepest_m = std::max(bin.deepest_m, patch.penetration_m);
    if (!(patch.volume_m3 > 0.0f)) continue;
    total_volume += patch.volume_m3;
    const glm::vec3 p_G = R_GS * patch.p_S;
    const float u = glm::dot(p_G, bin.tangents.u);
    const float v = glm::dot(p_G, bin.tangents.v);
    bin.load += patch.volume_m3;
    bin.sum_u += patch.volume_m3 * u;
    bin.sum_v += patch.volume_m3 * v;
    bin.sum_uu += patch.volume_m3 * u * u;
    bin.sum_vv += patch.volume_m3 * v * v;
  }

  // Which directions are cut, and the guards of each.
  for (Bin& bin : bins) {
    if (!(bin.load > 0.0f)) continue;
    const auto is_wide = [&](float sum, float squares, bool was_cut) {
      const float mean = sum / bin.load;
      const float limit = static_cast<float>(width_m) * (was_cut ? 0.7f : 1.0f);
      return squares / bin.load - mean * mean > limit * limit / 12.0f;  // an even patch of this width
    };
    bin.is_cut_u = is_wide(bin.sum_u, bin.sum_uu, bin.was_cut_u);
    bin.is_cut_v = is_wide(bin.sum_v, bin.sum_vv, bin.was_cut_v);
  }
  for (std::uint32_t i = 0; i < patches.size(); ++i) {
    const ContactPatch& patch = patches[i];
    const glm::vec3 n_G = R_GS * patch.n_S;
    Bin& bin = bins[DirectionBin(n_G)];
    const float nearness = patch.penetration_m - (bin.deepest_m - band);
    if (nearness < 0.0f) continue;
    bin.mean_normal_G += (nearness + 1e-6f) * n_G;
    if (patch.penetration_m > 0.0f) continue;
    const glm::vec3 p_G = R_GS * patch.p_S;
    const float u = glm::dot(p_G, bin.tangents.u);
    const float v = glm::dot(p_G, bin.tangents.v);
    const std::array<float, kNumGuards> merit{patch.penetration_m, u, v, -u, -v};
    for (std::size_t k = 0; k < kNumGuards; ++k) {
      const float bonus = patch.p_S == bin.previous_p_S[k] ? (k == 0 ? 1.0f : 4.0f) * hysteresis : 0.0f;
      if (merit[k] + bonus <= bin.preference[k]) continue;
      bin.preference[k] = merit[k] + bonus;
      bin.guards[k] = i;
    }
  }

  // Bins in contact by load, then the others by nearness.
  std::array<std::size_t, kNumDirectionBins> order;
  std::size_t num_used = 0;
  for (std::size_t b = 0; b < kNumDirectionBins; ++b) {
    if (bins[b].deepest_m > -kFar) order[num_used++] = b;
  }
  std::sort(order.begin(), order.begin() + num_used, [&](std::size_t a, std::size_t b) {
    if (bins[a].load != bins[b].load) return bins[a].load > bins[b].load;
    return bins[a].deepest_m != bins[b].deepest_m ? bins[a].deepest_m > bins[b].deepest_m : a < b;
  });
  num_used = std::min(num_used, kMaxPlanes);
  std::array<bool, kNumDirectionBins> is_used{};
  std::size_t num_free = kMaxPlanes - num_used;  // beyond one for each bin
  for (std::size_t k = 0; k < num_used; ++k) {
    Bin& bin = bins[order[k]];
    is_used[order[k]] = true;
    if (bin.num_cuts() > num_free) bin.is_cut_u = bin.is_cut_v = false;
    num_free -= bin.num_cuts();
  }

  for (const ContactPatch& patch : patches) {
    const std::size_t b = DirectionBin(R_GS * patch.n_S);
    if (!is_used[b] || !(patch.volume_m3 > 0.0f)) continue;
    bins[b].quarters[bins[b].quarter(R_GS * patch.p_S)].Add(patch);
  }
  std::array<Carrier, kMaxPlanes> carriers;
  std::size_t num_carriers = 0;
  for (std::size_t k = 0; k < num_used; ++k) {
    const Bin& bin = bins[order[k]];
    glm::dvec3 sum(0.0);
    for (const Sums& quarter : bin.quarters) sum += quarter.force;
    if (sum == glm::dvec3(0.0)) continue;
    const glm::dvec3 n = glm::normalize(sum);
    const double spread = bin.sum_uu + bin.sum_vv - (bin.sum_u * bin.sum_u + bin.sum_v * bin.sum_v) / bin.load;
    const double reach_m = width_m + 2.0 * std::sqrt(std::max(spread / bin.load, 0.0));
    for (std::uint32_t q = 0; q < kNumQuarters; ++q) {
      if (!(glm::dot(bin.quarters[q].force, n) > 0.0)) continue;
      const auto id = static_cast<std::uint32_t>(order[k]) * kSlots + q;
      carriers[num_carriers++] = Gather(id, bin.quarters[q], n, reach_m);
    }
  }
  // Patches may stand for others that were left out.
  for (std::size_t c = 0; c < num_carriers; ++c) carriers[c].force *= load.volume_m3 / total_volume;
  Balance(load, {carriers.data(), num_carriers});
  for (std::size_t c = 0; c < num_carriers; ++c) {
    const Carrier& carrier = carriers[c];
    const double length = glm::length(carrier.force);
    if (!(length > 0.0) || !(carrier.depth_m > 0.0)) continue;
    const glm::dvec3 n_G = X_GS.rotate(carrier.force) / length;
    core::ContactPlane plane;
    plane.id = carrier.id;
    plane.p_S = glm::vec3(carrier.place);
    plane.n_G = glm::vec3(n_G);
    plane.q_G = glm::vec3(X_GS * carrier.place + carrier.depth_m * n_G);
    plane.stiffness_N_per_m = static_cast<float>(load.modulus_N_per_m3 * length / carrier.depth_m);
    planes->push_back(plane);
  }

  num_free = kMaxPlanes - planes->size();
  std::size_t num_waiting = 0;  // bins that must still get their one plane
  for (std::size_t k = 0; k < num_used; ++k) num_waiting += bins[order[k]].load > 0.0f ? 0 : 1;
  for (std::size_t k = 0; k < num_used; ++k) {
    const Bin& bin = bins[order[k]];
    if (!(bin.load > 0.0f)) --num_waiting;
    std::array<std::uint32_t, kNumGuards> slots;
    std::size_t num_chosen = 0;
    for (std::uint32_t g = 0; g < kNumGuards && num_free > num_waiting; ++g) {
      const std::uint32_t candidate = bin.guards[g];
      bool is_new = candidate != kNone;
      for (std::size_t c = 0; c < num_chosen; ++c) is_new = is_new && bin.guards[slots[c]] != candidate;
      if (!is_new) continue;
      slots[num_chosen++] = g;
      --num_free;
    }
    float sum_of_shares = bin.load > 0.0f ? 1.0f : 0.0f;
    for (std::size_t c = 0; c < num_chosen; ++c) {
      sum_of_shares += GuardShare(patches[bin.guards[slots[c]]].penetration_m, band);
    }
    const float length = glm::length(bin.mean_normal_G);
    for (std::size_t c = 0; c < num_chosen; ++c) {
      const ContactPatch& patch = patches[bin.guards[slots[c]]];
      core::ContactPlane plane;
      plane.id = static_cast<std::uint32_t>(order[k]) * kSlots + kFirstGuard + slots[c];
      plane.p_S = patch.p_S;
      plane.n_G = length > 0.0f ? bin.mean_normal_G / length : R_GS * patch.n_S;
      // gap = n . (X_GS p_S - q) = -penetration, so the plane's point is the contact point moved along the normal.
      plane.q_G = R_GS * patch.p_S + p_GS + patch.penetration_m * plane.n_G;
      plane.stiffness_N_per_m =
          static_cast<float>(stiffness_N_per_m) * GuardShare(patch.penetration_m, band) / sum_of_shares;
      planes->push_back(plane);
    }
  }
}

}  // namespace vps
