#include "device/haply_messages.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace device {
namespace {

using nlohmann::json;

// Null: it is not there, or no object.
const json* Member(const json& object, const char* name) {
  const auto found = object.is_object() ? object.find(name) : object.end();
  return found != object.end() ? &*found : nullptr;
}
const json* FirstOf(const json& root, const char* list) {
  const json* const devices = Member(root, list);
  return devices != nullptr && devices->is_array() && !devices->empty() ? &devices->front() : nullptr;
}

// False: not all of these numbers are there and finite.
template <std::size_t N>
bool ReadNumbers(const json* object, const char* const (&names)[N], double (&to)[N]) {
  for (std::size_t i = 0; i < N; ++i) {
    const json* const number = object != nullptr ? Member(*object, names[i]) : nullptr;
    if (number == nullptr || !number->is_number()) return false;
    to[i] = number->get<double>();
    if (!std::isfinite(to[i])) return false;
  }
  return true;
}

constexpr const char* kAxes[3] = {"x", "y", "z"};
constexpr const char* kQuaternion[4] = {"w", "x", "y", "z"};

void ReadGrip(const json& root, HaplyState* state) {
  const json* grip = FirstOf(root, "wireless_verse_grip");
  if (grip == nullptr) grip = FirstOf(root, "verse_grip");
  const json* const its = grip != nullptr ? Member(*grip, "state") : nullptr;
  if (its == nullptr) return;
  double q[4];
  if (ReadNumbers(Member(*its, "orientation"), kQuaternion, q)) {
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (std::abs(norm - 1.0) < 0.05) {
      for (int i = 0; i < 4; ++i) state->quaternion[i] = q[i] / norm;
      state->has_grip = true;
    }
  }
  const json* const buttons = Member(*its, "buttons");
  std::uint64_t bit = 1;
  for (const char* name : {"a", "b", "c"}) {
    const json* const button = buttons != nullptr ? Member(*buttons, name) : nullptr;
    if (button != nullptr && button->is_boolean() && button->get<bool>()) state->buttons |= bit;
    bit <<= 1;
  }
}

}  // namespace

bool ReadHaplyState(std::string_view text, HaplyState* state) {
  const json root = json::parse(text, nullptr, false);
  *state = {};
  const json* const device = FirstOf(root, "inverse3");
  if (device == nullptr) return false;
  const json* const id = Member(*device, "device_id");
  const json* const its = Member(*device, "state");
  if (id == nullptr || !id->is_string() || its == nullptr) return false;
  state->device_id = id->get<std::string>();
  if (!ReadNumbers(Member(*its, "cursor_position"), kAxes, state->position_m)) return false;
  if (!ReadNumbers(Member(*its, "cursor_velocity"), kAxes, state->velocity_m_per_s)) return false;
  ReadGrip(root, state);
  return !state->device_id.empty();
}

std::string WriteHaplyForce(const std::string& device_id, const double (&force_N)[3]) {
  const json force = {{"x", force_N[0]}, {"y", force_N[1]}, {"z", force_N[2]}};
  const json device = {{"device_id", device_id}, {"commands", {{"set_cursor_force", {{"values", force}}}}}};
  // A device says its own id, so it may hold bytes that are no UTF-8.
  return json{{"inverse3", json::array({device})}}.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace device
