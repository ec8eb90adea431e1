#include "vps/force/reduce_patches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "vps/force/direction_bins.hpp"

namespace vps {
namespace {

constexpr std::size_t kMaxPlanes = core::kMaxContactPlanes;
constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr float kFar = std::numeric_limits<float>::infinity();

// Slots of a bin's planes: id = 16 bin + slot.
constexpr std::uint32_t kSlots = 16;
constexpr std::uint32_t kNumQuarters = 4;  // slots 0 to 3: load; bit 0: u > 0, bit 1: v > 0, when cut that way
constexpr std::uint32_t kFirstGuard = 4;   // nearest, then the four that lie farthest out
constexpr std::size_t kNumGuards = 5;

// Sums over patches in contact.
struct Sums {
  glm::vec3 force, moment, place;  // place: from the bin's first patch, times volume
  float volume, square;

  void Add(const ContactPatch& patch, const glm::vec3& from_first) {
    force += patch.force_m3;
    moment += patch.moment_m4;
    place += patch.volume_m3 * from_first;
    volume += patch.volume_m3;
    square += patch.square_m4;
  }
};

// Of one direction in G. Written when its first patch comes: most directions have none.
struct Bin {
  std::uint32_t direction;
  float deepest_m;
  glm::vec3 first_p_S;
  glm::vec3 u_S, v_S;  // tangents
  // Load.
  Sums whole;
  float square_u, square_v;  // of the places along the tangents, weighted with volume
  bool is_cut_u, is_cut_v, was_cut_u, was_cut_v;
  std::array<Sums, kNumQuarters> quarters;
  // Guards.
  bool has_guards;
  glm::vec3 mean_normal_G;
  std::array<std::uint32_t, kNumGuards> guards;
  std::array<float, kNumGuards> preference;
  std::array<glm::vec3, kNumGuards> previous_p_S;  // NaN: none

  void Begin(std::uint32_t of_direction, const ContactPatch& first, const glm::mat3& R_SG,
             std::span<const core::ContactPlane> previous) {
    direction = of_direction;
    deepest_m = -kFar;
    first_p_S = first.p_S;
    const Tangents& tangents = BinTangents(of_direction == 13 ? 0 : of_direction);
    u_S = R_SG * tangents.u;
    v_S = R_SG * tangents.v;
    whole = {};
    square_u = square_v = 0.0f;
    is_cut_u = is_cut_v = was_cut_u = was_cut_v = has_guards = false;
    mean_normal_G = glm::vec3(0.0f);
    guards.fill(kNone);
    preference.fill(-kFar);
    previous_p_S.fill(glm::vec3(std::numeric_limits<float>::quiet_NaN()));
    for (const core::ContactPlane& plane : previous) {
      if (plane.id / kSlots != of_direction) continue;
      const std::uint32_t slot = plane.id % kSlots;
      if (slot < kNumQuarters) {
        was_cut_u = was_cut_u || (slot & 1U) != 0;
        was_cut_v = was_cut_v || (slot & 2U) != 0;
      } else if (slot < kFirstGuard + kNumGuards) {
        previous_p_S[slot - kFirstGuard] = plane.p_S;
      }
    }
  }
  void AddFirst(const ContactPatch& patch) {
    deepest_m = std::max(deepest_m, patch.penetration_m);
    has_guards = has_guards || patch.penetration_m <= 0.0f;
    if (!(patch.volume_m3 > 0.0f)) return;
    const glm::vec3 r = patch.p_S - first_p_S;
    const float u = glm::dot(r, u_S);
    const float v = glm::dot(r, v_S);
    whole.Add(patch, r);
    square_u += patch.volume_m3 * u * u;
    square_v += patch.volume_m3 * v * v;
  }
  [[nodiscard]] bool is_loaded() const { return whole.volume > 0.0f; }
  // Sum of squared distances from the mean along a tangent, times volume.
  [[nodiscard]] float Spread(const glm::vec3& tangent, float square) const {
    const float sum = glm::dot(whole.place, tangent);
    return square - sum * sum / whole.volume;
  }
  // Along each tangent: whether the load is wider than a uniform one of width w = `width_m`, whose variance is w^2
  // / 12. A bin that was cut stays cut down to 0.7 w (not derived), so that planes do not come and go.
  void Cut(float width_m) {
    const auto is_wide = [&](const glm::vec3& tangent, float square, bool was_cut) {
      const float limit = width_m * (was_cut ? 0.7f : 1.0f);
      return Spread(tangent, square) > whole.volume * limit * limit / 12.0f;
    };
    is_cut_u = is_wide(u_S, square_u, was_cut_u);
    is_cut_v = is_wide(v_S, square_v, was_cut_v);
  }
  [[nodiscard]] std::size_t num_cuts() const { return (is_cut_u ? 2U : 1U) * (is_cut_v ? 2U : 1U) - 1U; }
  void AddToQuarter(const ContactPatch& patch) {
    if (!(patch.volume_m3 > 0.0f)) return;
    const glm::vec3 r = patch.p_S - first_p_S;
    const glm::vec3 from_middle = whole.volume * r - whole.place;
    const bool is_u = is_cut_u && glm::dot(from_middle, u_S) > 0.0f;
    const bool is_v = is_cut_v && glm::dot(from_middle, v_S) > 0.0f;
    quarters[(is_u ? 1U : 0U) | (is_v ? 2U : 0U)].Add(patch, r);
  }
  void ConsiderAsGuard(const ContactPatch& patch, std::uint32_t index, float band_m, float hysteresis_m) {
    const float nearness = patch.penetration_m - (deepest_m - band_m);
    if (nearness < 0.0f) return;
    mean_normal_G += (nearness + 1e-6f) * patch.n_G;
    if (patch.penetration_m > 0.0f) return;
    const glm::vec3 r = patch.p_S - first_p_S;
    const float u = glm::dot(r, u_S);
    const float v = glm::dot(r, v_S);
    const std::array<float, kNumGuards> merit{patch.penetration_m, u, v, -u, -v};
    for (std::size_t k = 0; k < kNumGuards; ++k) {
      const float bonus = patch.p_S == previous_p_S[k] ? (k == 0 ? 1.0f : 4.0f) * hysteresis_m : 0.0f;
      if (merit[k] + bonus <= preference[k]) continue;
      preference[k] = merit[k] + bonus;
      guards[k] = index;
    }
  }
};

// A force at a place.
struct Carrier {
  std::uint32_t id = 0;
  glm::dvec3 force{0.0}, place{0.0};
  double depth_m = 0.0;
};

// The carrier of a group with force F [m^3], moment M [m^4] and load centre c [m]: its force f = (n . F) n along the
// unit n, at the point of the force's axis nearest to c, p = c + f x (M - c x F) / f^2; at c itself where forces nearly
// cancel and the axis lies farther away than reach_m. Depth d = (integral of depth^2) / (integral of depth).
Carrier Gather(std::uint32_t id, const Sums& sums, const glm::vec3& first_p_S, const glm::dvec3& n, double reach_m) {
  const glm::dvec3 force(sums.force);
  const double volume = sums.volume;
  Carrier carrier{id, glm::dot(force, n) * n, glm::dvec3(first_p_S) + glm::dvec3(sums.place) / volume,
                  static_cast<double>(sums.square) / volume};
  const glm::dvec3 rest = glm::dvec3(sums.moment) - glm::cross(carrier.place, force);
  const glm::dvec3 shift = glm::cross(carrier.force, rest) / glm::dot(carrier.force, carrier.force);
  if (glm::dot(shift, shift) < reach_m * reach_m) carrier.place += shift;
  return carrier;
}

// Distributes what the carriers lack of the load, force l and moment m about their mean place, as derived in the
// header: df_i = w_i (l + a x r_i),  w_i = |f_i| / sum |f|,  [sum w (r^2 I - r r^T)] a = m.
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
  // |a x r_i| is limited to a quarter of the mean force (not derived): the rest of a moment that places so close
  // together cannot carry is dropped. 1e-6 of the trace keeps the inertia of places in one line invertible.
  double most = 0.0;
  for (const Carrier& c : carriers) most = std::max(most, glm::length(glm::cross(turn, c.place - mean)) / total);
  if (most > 0.25) turn *= 0.25 / most;
  for (Carrier& c : carriers) {
    c.force += glm::length(c.force) / total * (force + glm::cross(turn, c.place - mean));
  }
}

// At most `most` planes for the guards of a bin.
void AddGuards(const Bin& bin, std::span<const ContactPatch> patches, const core::Pose& X_GS, const glm::mat3& R_GS,
               double stiffness_N_per_m, float band_m, std::size_t most, ContactPlanes* planes) {
  std::array<std::uint32_t, kNumGuards> slots;
  std::size_t num_chosen = 0;
  float sum_of_shares = bin.is_loaded() ? 1.0f : 0.0f;
  for (std::uint32_t g = 0; g < kNumGuards && num_chosen < most; ++g) {
    const std::uint32_t candidate = bin.guards[g];
    bool is_new = candidate != kNone;
    for (std::size_t c = 0; c < num_chosen; ++c) is_new = is_new && bin.guards[slots[c]] != candidate;
    if (!is_new) continue;
    slots[num_chosen++] = g;
    sum_of_shares += GuardShare(patches[candidate].penetration_m, band_m);
  }
  if (num_chosen == 0) return;
  const glm::vec3 n_G = glm::normalize(bin.mean_normal_G);
  for (std::size_t c = 0; c < num_chosen; ++c) {
    const ContactPatch& patch = patches[bin.guards[slots[c]]];
    core::ContactPlane plane;
    plane.id = bin.direction * kSlots + kFirstGuard + slots[c];
    plane.p_S = patch.p_S;
    plane.n_G = n_G;
    // gap = n . (X_GS p_S - q) = -penetration, so the plane's point is the contact point moved along the normal.
    plane.q_G = R_GS * patch.p_S + glm::vec3(X_GS.translation) + patch.penetration_m * plane.n_G;
    plane.stiffness_N_per_m =
        static_cast<float>(stiffness_N_per_m) * GuardShare(patch.penetration_m, band_m) / sum_of_shares;
    planes->push_back(plane);
  }
}

}  // namespace

void ReducePatches(std::span<const ContactPatch> patches, const core::Pose& X_GS, const ContactLoad& load,
                   double stiffness_N_per_m, double band_m, double width_m, ContactPlanes* planes,
                   double hysteresis_m) {
  const ContactPlanes previous = *planes;
  planes->clear();
  if (patches.empty()) return;
  const glm::mat3 R_GS(glm::mat3_cast(X_GS.rotation));
  const glm::mat3 R_SG = glm::transpose(R_GS);
  const auto band = static_cast<float>(band_m);
  const auto hysteresis = static_cast<float>(hysteresis_m);

  std::array<Bin, kNumDirectionBins> bins;
  std::array<std::uint8_t, kNumDirectionBins> bin_of_direction{};  // plus one; 0: none
  std::array<std::uint8_t, kMaxPatches> bin_of_patch;
  std::uint8_t num_bins = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const ContactPatch& patch = patches[i];
    const std::size_t direction = DirectionBin(patch.n_G);
    if (bin_of_direction[direction] == 0) {
      bins[num_bins].Begin(static_cast<std::uint32_t>(direction), patch, R_SG, {previous.begin(), previous.end()});
      bin_of_direction[direction] = ++num_bins;
    }
    bin_of_patch[i] = static_cast<std::uint8_t>(bin_of_direction[direction] - 1);
    bins[bin_of_patch[i]].AddFirst(patch);
  }

  // Bins in contact by load, then the others by nearness.
  std::array<std::uint8_t, kNumDirectionBins> order;
  std::iota(order.begin(), order.begin() + num_bins, std::uint8_t{0});
  std::sort(order.begin(), order.begin() + num_bins, [&](std::size_t at_a, std::size_t at_b) {
    const Bin& a = bins[at_a];
    const Bin& b = bins[at_b];
    if (a.whole.volume != b.whole.volume) return a.whole.volume > b.whole.volume;
    return a.deepest_m != b.deepest_m ? a.deepest_m > b.deepest_m : a.direction < b.direction;
  });
  const std::size_t num_used = std::min<std::size_t>(num_bins, kMaxPlanes);
  std::size_t num_free = kMaxPlanes - num_used;  // beyond one for each bin
  double total_volume = 0.0;
  bool is_done = true;
  for (std::size_t k = 0; k < num_used; ++k) {
    Bin& bin = bins[order[k]];
    is_done = is_done && !bin.has_guards;
    if (!bin.is_loaded()) continue;
    total_volume += static_cast<double>(bin.whole.volume);
    bin.Cut(static_cast<float>(width_m));
    if (bin.num_cuts() > num_free) bin.is_cut_u = bin.is_cut_v = false;
    num_free -= bin.num_cuts();
    if (bin.num_cuts() == 0) {
      bin.quarters[0] = bin.whole;
    } else {
      bin.quarters.fill({});
      is_done = false;
    }
  }
  for (std::size_t k = num_used; k < num_bins; ++k) {
    Bin& bin = bins[order[k]];
    total_volume += static_cast<double>(bin.whole.volume);
    bin.has_guards = false;
  }
  for (std::uint32_t i = 0; i < patches.size() && !is_done; ++i) {
    Bin& bin = bins[bin_of_patch[i]];
    if (bin.is_cut_u || bin.is_cut_v) bin.AddToQuarter(patches[i]);
    if (bin.has_guards) bin.ConsiderAsGuard(patches[i], i, band, hysteresis);
  }

  std::array<Carrier, kMaxPlanes> carriers;
  std::size_t num_carriers = 0;
  for (std::size_t k = 0; k < num_used; ++k) {
    const Bin& bin = bins[order[k]];
    if (!bin.is_loaded() || bin.whole.force == glm::vec3(0.0f)) continue;
    const glm::dvec3 n = glm::normalize(glm::dvec3(bin.whole.force));
    const auto spread =
        static_cast<double>((bin.Spread(bin.u_S, bin.square_u) + bin.Spread(bin.v_S, bin.square_v)) / bin.whole.volume);
    const double reach_m = width_m + 2.0 * std::sqrt(std::max(spread, 0.0));
    for (std::uint32_t q = 0; q <= bin.num_cuts(); ++q) {
      const std::uint32_t quarter = bin.is_cut_u ? q : 2 * q;
      const Sums& sums = bin.quarters[quarter];
      if (!(glm::dot(glm::dvec3(sums.force), n) > 0.0)) continue;
      carriers[num_carriers++] = Gather(bin.direction * kSlots + quarter, sums, bin.first_p_S, n, reach_m);
    }
  }
  // What is not known of a load does not count (Combine); directions beyond kMaxPlanes have no plane.
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
    // Of the plane in floats, so that its force is the carrier's: places are rounded by up to 1e-4 of a small depth.
    const double depth_m = glm::dot(glm::dvec3(plane.n_G), glm::dvec3(plane.q_G) - X_GS * glm::dvec3(plane.p_S));
    if (!(depth_m > 0.0)) continue;
    plane.stiffness_N_per_m = static_cast<float>(load.modulus_N_per_m3 * length / depth_m);
    planes->push_back(plane);
  }

  num_free = kMaxPlanes - planes->size();
  std::size_t num_waiting = 0;  // bins that must still get their one plane
  for (std::size_t k = 0; k < num_used; ++k) num_waiting += bins[order[k]].is_loaded() ? 0 : 1;
  for (std::size_t k = 0; k < num_used; ++k) {
    const Bin& bin = bins[order[k]];
    if (!bin.is_loaded()) --num_waiting;
    if (!bin.has_guards) continue;
    AddGuards(bin, patches, X_GS, R_GS, stiffness_N_per_m, band, num_free - std::min(num_free, num_waiting), planes);
    num_free = kMaxPlanes - planes->size();
  }
}

}  // namespace vps
