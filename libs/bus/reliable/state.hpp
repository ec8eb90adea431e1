#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace bus {

namespace detail {
struct StateSender;
struct StateAccess;
}  // namespace detail

// Writing end of a STATE topic (M: core::LogicStatus or bus::Figures): retains the last value of each key for late
// joiners. A handle, for the step thread.
template <class M>
class StateWriter {
 public:
  StateWriter() = default;
  // Retains and sends. False: the queue to the bus thread is full, or the value is larger than 64 KiB.
  bool Set(const M& value, const std::string& key = {});

 private:
  friend class Node;
  detail::StateSender* sender_ = nullptr;
};

// Reading end: a snapshot when it joins, then deltas, so it holds the complete state. Updated by Node::Wait().
template <class M>
class StateReader {
 public:
  [[nodiscard]] const M& value() const { return value_; }  // of the key that changed last
  [[nodiscard]] bool has_value() const { return !values_.empty(); }
  [[nodiscard]] bool is_fresh() const { return is_fresh_; }                         // the last Wait() brought a change
  [[nodiscard]] const std::map<std::string, M>& values() const { return values_; }  // by key
  [[nodiscard]] std::uint64_t version() const { return version_; }  // of the writer, grows with every change

 private:
  friend class Node;
  friend struct detail::StateAccess;
  M value_{};
  std::map<std::string, M> values_;
  std::uint64_t version_ = 0;
  bool is_fresh_ = false;
};

}  // namespace bus
