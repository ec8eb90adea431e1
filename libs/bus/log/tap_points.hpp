#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bus/log/tap.hpp"
#include "bus/node.hpp"

namespace bus::detail {

struct StateItem;
struct ParameterAnswer;

// Clock offsets, bounds and drifts of the live peers.
std::vector<log::PeerClock> ClocksOf(const std::vector<PeerStatus>& peers);

// Writes what a node sends and receives to its tap. All calls are of the step thread, in the order in which it sends
// and receives; without a tap they do nothing. Except the declarations, none blocks, locks or allocates.
class TapPoints {
 public:
  void Attach(log::Tap* tap);  // before anything is declared
  [[nodiscard]] log::Tap* tap() const { return tap_; }

  std::uint16_t Declare(log::TapKind kind, const std::string& topic, TopicClass topic_class, MessageType type);
  void DeclareStateWriter(const std::string& topic, MessageType type);  // in the order of their slots
  void DeclareStateReader(const std::string& topic, MessageType type);

  void WroteState(std::uint32_t slot, const std::string& key, std::span<const char> bytes) noexcept;
  void TookState(const StateItem& item) noexcept;
  void Emitted(const core::Event& event) noexcept;
  void TookEvent(const core::Event& event) noexcept;
  void Posted(std::uint64_t request, const std::string& owner, const core::ParameterChange& change) noexcept;
  void TookParameter(std::uint64_t ticket, const core::ParameterChange& change) noexcept;
  void Answered(const ParameterAnswer& answer) noexcept;
  void TookAck(const ParameterAck& ack) noexcept;

 private:
  log::Tap* tap_ = nullptr;
  std::vector<std::uint16_t> state_writers_, state_readers_;
  std::uint16_t events_out_ = 0, events_in_ = 0, calls_ = 0, parameters_ = 0, answers_ = 0, acks_ = 0;
  std::uint64_t num_states_ = 0;  // every Set is one version of the owner's state
  std::uint64_t num_emitted_ = 0, num_heard_ = 0;
};

}  // namespace bus::detail
