#include "hug/faults.hpp"

#include <charconv>
#include <cmath>
#include <string>

#include "core/names.hpp"

namespace hug {
namespace {

struct NamedKind {
  const char* name;
  FaultKind kind;
  bool has_amount;
};
constexpr NamedKind kKinds[] = {
    {"loss", FaultKind::kLoss, true},
    {"delay", FaultKind::kDelay, true},
    {"jitter", FaultKind::kJitter, true},
    {"stuck_sensor", FaultKind::kStuckSensor, false},
    {"encoder_jump", FaultKind::kEncoderJump, true},
    {"torque_bias", FaultKind::kTorqueBias, true},
    {"force_bias", FaultKind::kForceBias, true},
    {"dead_man_glitch", FaultKind::kDeadManGlitch, false},
    {"clutch_trip", FaultKind::kClutchTrip, false},
    {"overheat", FaultKind::kOverheat, false},
    {"unplug", FaultKind::kUnplug, false},
};

std::string_view NextWord(std::string_view* text) {
  while (!text->empty() && text->front() == ' ') text->remove_prefix(1);
  const std::size_t length = std::min(text->find(' '), text->size());
  const std::string_view word = text->substr(0, length);
  text->remove_prefix(length);
  return word;
}

bool ReadNumber(std::string_view word, double* value) {
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *value);
  return error == std::errc() && end == word.data() + word.size() && std::isfinite(*value) && *value >= 0.0;
}

core::Result<Fault> ParseFault(std::string_view text) {
  const auto refuse = [whole = std::string(text)](const std::string& why) {
    return core::Fail(
        core::ErrorCode::kInvalidInput,
        "fault '" + whole + "': " + why + "; write for instance 'encoder_jump 0.05 joint 3 at 2 for 0.5'");
  };
  const std::string name(NextWord(&text));
  const NamedKind* known = nullptr;
  std::vector<std::string> names;
  for (const NamedKind& kind : kKinds) {
    if (name == kind.name) known = &kind;
    names.emplace_back(kind.name);
  }
  if (known == nullptr) return refuse("no fault has the name '" + name + "'; " + core::SuggestName(name, names));
  Fault fault;
  fault.kind = known->kind;
  if (known->has_amount && !ReadNumber(NextWord(&text), &fault.amount)) return refuse("its amount is missing");
  double duration_s = 1e9;
  for (std::string_view word = NextWord(&text); !word.empty(); word = NextWord(&text)) {
    double value = 0.0;
    if (!ReadNumber(NextWord(&text), &value)) return refuse("after '" + std::string(word) + "' a number is missing");
    if (word == "at") {
      fault.begin_s = value;
    } else if (word == "for") {
      duration_s = value;
    } else if (word == "joint" && value >= 1.0 && value <= 7.0) {
      fault.joint = static_cast<int>(value) - 1;
    } else {
      return refuse("'" + std::string(word) + "' is not known, or out of range");
    }
  }
  fault.end_s = fault.begin_s + duration_s;
  return fault;
}

}  // namespace

core::Result<std::vector<Fault>> ParseFaults(std::string_view text) {
  std::vector<Fault> faults;
  while (!text.empty()) {
    const std::size_t length = std::min(text.find(';'), text.size());
    const std::string_view part = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    if (part.find_first_not_of(' ') == std::string_view::npos) continue;
    auto fault = ParseFault(part.substr(part.find_first_not_of(' ')));
    if (!fault) return tl::unexpected(fault.error());
    faults.push_back(*fault);
  }
  return faults;
}

}  // namespace hug
