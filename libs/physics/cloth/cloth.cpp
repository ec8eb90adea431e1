#include "physics/cloth/cloth.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/hash.hpp"

namespace physics {
namespace {

constexpr std::size_t kMaxGrips = 128;       // gripped nodes; chosen, far above those between two pads
constexpr std::size_t kContactsPerNode = 3;  // capacity for contacts: a node in a corner of three bodies

}  // namespace

core::Result<std::unique_ptr<Cloth>> Cloth::Create(const ClothParams& params) {
  auto grid = BuildClothGrid(params);
  if (!grid) return core::Fail(grid.error().code, grid.error().detail);
  return std::unique_ptr<Cloth>(new Cloth(params, std::move(*grid)));
}

Cloth::Cloth(const ClothParams& params, ClothGrid&& grid)
    : params_(params), grid_(std::move(grid)), x_W_(grid_.p_W), v_W_(grid_.p_W.size(), glm::dvec3(0.0)) {
  for (const double mass : grid_.mass_kg) {
    inverse_mass_.push_back(1.0 / mass);
    mass_kg_ += mass;
  }
  is_gripped_.resize(x_W_.size(), 0);
  spring_states_.resize(grid_.springs.size());
  contacts_.reserve(x_W_.size() * kContactsPerNode);
  holds_.reserve(kMaxGrips);
}

core::Result<int> Cloth::AddBody(const ClothBodyParams& params) {
  if (params.kind == BodyKind::kDynamic && !IsPhysical(params.mass)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "cloth: body " + std::to_string(bodies_.size()) + " moves freely but has no real mass");
  }
  Body body;
  body.kind = params.kind;
  body.shape = params.shape;
  body.X_WO = params.X_WO;
  body.X_WO_target = params.X_WO;
  if (params.kind == BodyKind::kDynamic) {
    body.p_OCm = params.mass.p_OCm_m;
    body.I_Cm_O = params.mass.I_Cm_O_kg_m2;
    body.inverse_mass = 1.0 / params.mass.mass_kg;
  }
  body.p_WCm = body.X_WO * body.p_OCm;
  bodies_.push_back(std::move(body));
  return static_cast<int>(bodies_.size()) - 1;
}

core::Result<int> Cloth::AddBond(const ClothBondParams& params, const std::vector<glm::dvec3>& points_W) {
  if (params.body < 0 || static_cast<std::size_t>(params.body) >= bodies_.size()) {
    return core::Fail(core::ErrorCode::kInvalidInput, "cloth: a bond refers to a body that does not exist");
  }
  const core::Pose X_SW = params_.X_WS.inverse();
  const Body& body = bodies_[static_cast<std::size_t>(params.body)];
  for (std::size_t i = 0; i < points_W.size(); ++i) {
    const glm::dvec3 p_S = X_SW * points_W[i];
    // Position in cells from the lower corner. A hundredth of a cell outside is accepted as rounding of the border.
    const double u = (p_S.x / params_.size_x_m + 0.5) * params_.cells_x;
    const double v = (p_S.y / params_.size_y_m + 0.5) * params_.cells_y;
    if (u < -0.01 || v < -0.01 || u > params_.cells_x + 0.01 || v > params_.cells_y + 0.01) {
      return core::Fail(core::ErrorCode::kInvalidInput,
                        "cloth: point " + std::to_string(i) + " of a bond is outside the sheet, at " +
                            std::to_string(p_S.x) + " " + std::to_string(p_S.y) + " m from its middle");
    }
    const int ci = std::clamp(static_cast<int>(u), 0, params_.cells_x - 1);
    const int cj = std::clamp(static_cast<int>(v), 0, params_.cells_y - 1);
    const double s = std::clamp(u - ci, 0.0, 1.0);
    const double t = std::clamp(v - cj, 0.0, 1.0);
    const auto node = [&](int di, int dj) {
      return static_cast<std::uint32_t>((cj + dj) * (params_.cells_x + 1) + ci + di);
    };
    Hold hold;
    hold.node = {node(0, 0), node(1, 0), node(0, 1), node(1, 1)};
    hold.weight = {(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t};
    hold.body = params.body;
    hold.bond = static_cast<int>(bonds_.size());
    glm::dvec3 p_W(0.0);
    for (std::size_t k = 0; k < 4; ++k) p_W += hold.weight[k] * x_W_[hold.node[k]];
    hold.p_O = body.X_WO.inverse() * p_W;
    hold.stiffness_N_per_m = params.stiffness_N_per_m;
    hold.damping_N_s_per_m = params.damping_N_s_per_m;
    holds_.push_back(hold);
  }
  num_bonded_ = holds_.size();
  holds_.reserve(num_bonded_ + kMaxGrips);
  bonds_.push_back({params.body, params.release_force_N, static_cast<int>(points_W.size()), glm::dvec3(0.0)});
  return static_cast<int>(bonds_.size()) - 1;
}

void Cloth::SetBody(int index, const core::Pose& X_WO, const core::Twist& V_WO) {
  Body& body = bodies_[static_cast<std::size_t>(index)];
  body.X_WO_target = X_WO;
  if (body.kind == BodyKind::kDynamic || !body.is_placed) body.X_WO = X_WO;
  body.is_placed = true;
  if (body.kind == BodyKind::kDynamic) {
    body.w_W = V_WO.angular_rad_per_s;
    body.v_W = core::PointVelocity(V_WO, X_WO.rotate(body.p_OCm));
  }
}

void Cloth::Rest() {
  std::fill(v_W_.begin(), v_W_.end(), glm::dvec3(0.0));
  for (Body& body : bodies_) body.is_placed = false;
}

void Cloth::SetReleaseForce(int bond, double release_force_N) {
  bonds_[static_cast<std::size_t>(bond)].release_force_N = release_force_N;
}

bool Cloth::IsInside(std::size_t node, const core::Pose& X_OW, const glm::dvec3& lower_O,
                     const glm::dvec3& upper_O) const {
  const glm::dvec3 p_O = X_OW * x_W_[node];
  return is_gripped_[node] == 0 && glm::all(glm::greaterThanEqual(p_O, lower_O)) &&
         glm::all(glm::lessThanEqual(p_O, upper_O));
}

int Cloth::CountInside(int body, const glm::dvec3& lower_O, const glm::dvec3& upper_O) const {
  const core::Pose X_OW = bodies_[static_cast<std::size_t>(body)].X_WO.inverse();
  int count = 0;
  for (std::size_t i = 0; i < x_W_.size(); ++i) count += IsInside(i, X_OW, lower_O, upper_O) ? 1 : 0;
  return count;
}

int Cloth::Grip(const ClothBondParams& params, const glm::dvec3& lower_O, const glm::dvec3& upper_O) {
  Release(params.body);
  const core::Pose X_OW = bodies_[static_cast<std::size_t>(params.body)].X_WO.inverse();
  int count = 0;
  for (std::size_t i = 0; i < x_W_.size(); ++i) {
    if (!IsInside(i, X_OW, lower_O, upper_O) || holds_.size() == num_bonded_ + kMaxGrips) continue;
    const auto node = static_cast<std::uint32_t>(i);
    Hold hold;
    hold.node = {node, node, node, node};
    hold.weight = {1.0, 0.0, 0.0, 0.0};
    hold.body = params.body;
    hold.bond = -1;
    hold.p_O = X_OW * x_W_[i];
    hold.stiffness_N_per_m = params.stiffness_N_per_m;
    hold.damping_N_s_per_m = params.damping_N_s_per_m;
    holds_.push_back(hold);
    is_gripped_[i] = 1;
    ++count;
  }
  return count;
}

void Cloth::Release(int body) {
  std::erase_if(holds_, [&](const Hold& hold) {
    const bool is_mine = hold.bond < 0 && hold.body == body;
    if (is_mine) is_gripped_[hold.node[0]] = 0;
    return is_mine;
  });
}

int Cloth::num_gripped(int body) const {
  return static_cast<int>(std::count_if(holds_.begin(), holds_.end(),
                                        [&](const Hold& hold) { return hold.bond < 0 && hold.body == body; }));
}

int Cloth::held(int bond) const {
  return bonds_[static_cast<std::size_t>(bond)].num_held;
}

core::Wrench Cloth::MeanWrenchOn(int index, const glm::dvec3& p_W) const {
  const Body& body = bodies_[static_cast<std::size_t>(index)];
  if (body.duration_s <= 0.0) return {};
  return {body.impulse_Ns / body.duration_s, (body.moment_Nms - glm::cross(p_W, body.impulse_Ns)) / body.duration_s};
}

glm::dvec3 Cloth::BondForce_W(int index) const {
  const Bond& bond = bonds_[static_cast<std::size_t>(index)];
  const double duration_s = bodies_[static_cast<std::size_t>(bond.body)].duration_s;
  return duration_s > 0.0 ? bond.impulse_Ns / duration_s : glm::dvec3(0.0);
}

glm::dvec3 Cloth::momentum_Ns() const {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < v_W_.size(); ++i) sum += grid_.mass_kg[i] * v_W_[i];
  return sum;
}

glm::dvec3 Cloth::angular_momentum_Nms() const {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < v_W_.size(); ++i) sum += grid_.mass_kg[i] * glm::cross(x_W_[i], v_W_[i]);
  return sum;
}

double Cloth::kinetic_J() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < v_W_.size(); ++i) sum += 0.5 * grid_.mass_kg[i] * glm::dot(v_W_[i], v_W_[i]);
  return sum;
}

double Cloth::elastic_J() const {
  double sum = 0.0;
  for (const ClothGrid::Spring& spring : grid_.springs) {
    const glm::dvec3 line = x_W_[spring.b] - x_W_[spring.a];
    const double stretch = std::sqrt(glm::dot(line, line)) - spring.rest_m;
    sum += 0.5 * spring.stiffness_N_per_m * stretch * stretch;
  }
  for (const ClothGrid::Bend& bend : grid_.bends) {
    glm::dvec3 curl(0.0);
    for (std::size_t k = 0; k < 4; ++k) curl += bend.weight[k] * x_W_[bend.node[k]];
    sum += 0.5 * bend.stiffness_N_per_m * glm::dot(curl, curl);
  }
  return sum;
}

double Cloth::energy_J() const {
  return kinetic_J() + elastic_J();
}

void Cloth::ExchangeState(Checkpoint* checkpoint) {
  for (glm::dvec3& x : x_W_) checkpoint->Exchange(&x);
  for (glm::dvec3& v : v_W_) checkpoint->Exchange(&v);
  for (SpringState& s : spring_states_) checkpoint->Exchange(&s.impulse_Ns);
  // Writes the full capacity of grips, so that all checkpoints have the same size.
  std::size_t num_holds = holds_.size();
  checkpoint->Exchange(&num_holds);
  const std::size_t most = num_bonded_ + kMaxGrips;
  holds_.resize(most);
  for (Hold& hold : holds_) checkpoint->Exchange(&hold);
  holds_.resize(std::min(num_holds, most));
  for (Bond& bond : bonds_) checkpoint->Exchange(&bond);
  for (std::uint8_t& flag : is_gripped_) checkpoint->Exchange(&flag);
  for (Body& body : bodies_) {
    checkpoint->Exchange(&body.X_WO);
    checkpoint->Exchange(&body.X_WO_target);
    checkpoint->Exchange(&body.is_placed);
    checkpoint->Exchange(&body.v_W);
    checkpoint->Exchange(&body.w_W);
    checkpoint->Exchange(&body.impulse_Ns);
    checkpoint->Exchange(&body.moment_Nms);
    checkpoint->Exchange(&body.duration_s);
  }
}

std::uint64_t Cloth::StateHash() const {
  const std::uint64_t hash = core::Hash64(x_W_.data(), x_W_.size() * sizeof(glm::dvec3));
  return core::Hash64(v_W_.data(), v_W_.size() * sizeof(glm::dvec3), hash);
}

}  // namespace physics
