#include "tracking/dtrack.hpp"

#include <cmath>
#include <string_view>

#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"
#include "tracking/finger_angles.hpp"
#include "tracking/glove.hpp"
#include "tracking/pinch.hpp"

namespace fuzz {
namespace {

void CheckBody(const tracking::TrackedBody& body) {
  Claim(body.id >= 0, "an id is a count");
  const glm::dquat& q = body.X_TB.rotation;
  Claim(std::abs(glm::dot(q, q) - 1.0) < 1e-9, "a rotation is one");
  for (int i = 0; i < 3; ++i) Claim(std::isfinite(body.X_TB.translation[i]), "a place is finite");
}

}  // namespace

void FuzzDtrack(Input input) {
  std::vector<std::string> complaints;
  const tracking::DtrackFrame frame =
      tracking::ParseDtrack({reinterpret_cast<const char*>(input.data()), input.size()}, &complaints);
  for (const auto& body : frame.bodies) CheckBody(body);
  for (const auto& stick : frame.flysticks) {
    CheckBody(stick.body);
    Claim(stick.num_controllers >= 0 && stick.num_controllers <= 8, "controllers have room");
  }
  for (const auto& hand : frame.hands) {
    CheckBody(hand.body);
    Claim(hand.fingers.size() <= 5, "a hand has five fingers at most");
    const auto angles_rad = tracking::AnglesOf(hand);
    for (std::size_t i = 0; angles_rad && i < angles_rad->size(); ++i) {
      Claim(std::isfinite((*angles_rad)[i]), "an angle is finite");
    }
  }
}

void FuzzPinch(Input input) {
  const auto pinch = tracking::ParsePinch({reinterpret_cast<const char*>(input.data()), input.size()}, 1);
  Claim(!pinch || (*pinch >= 0.0 && *pinch <= 1.0), "a pinch is a share");
}

void FuzzGlove(Input input) {
  const auto angles_rad = tracking::ParseGlove({reinterpret_cast<const char*>(input.data()), input.size()}, 1);
  for (std::size_t i = 0; angles_rad && i < angles_rad->size(); ++i) {
    Claim(std::abs((*angles_rad)[i]) <= 3.15, "no joint turns by more than half a turn");
  }
}

}  // namespace fuzz
