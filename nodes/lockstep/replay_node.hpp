#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bus/log/mcap_records.hpp"
#include "core/messages/logic.hpp"
#include "core/result.hpp"
#include "replay/difference.hpp"
#include "scene/scenario.hpp"

namespace lockstep {

// What a recording says about the steps of one node.
struct RecordedNode {
  std::string node;
  bus::log::TextMap about;
  std::string fields;                    // what a step is made of
  std::vector<std::uint8_t> checkpoint;  // empty: it begins where the node begins
};

// The nodes whose steps are in the file, or an error (kIo, kDamaged).
core::Result<std::vector<RecordedNode>> ReadRecordedNodes(const std::filesystem::path& file);

struct ReplayOptions {
  std::filesystem::path cache;  // of cooked structures
  std::function<void(const std::string&)> say;
};

// A node without its bus, fed with recorded steps.
class ReplayedNode {
 public:
  // `scenario`: what the node is built from. Errors: a node that cannot be replayed, steps of another version of this
  // program, a checkpoint that does not fit.
  static core::Result<std::unique_ptr<ReplayedNode>> Create(const RecordedNode& recorded,
                                                            const scene::Scenario& scenario,
                                                            const ReplayOptions& options);
  virtual ~ReplayedNode() = default;

  // Reads a step. False: damaged, or something before it is missing.
  virtual bool Read(std::span<const std::uint8_t> step) = 0;
  [[nodiscard]] virtual std::uint64_t tick() const = 0;  // of the step that was read
  [[nodiscard]] virtual std::int64_t now_ns() const = 0;
  // Of the first step's tick, when the node does not stand before it; of a step that hung on the clock: why it cannot
  // be repeated. Else empty.
  [[nodiscard]] virtual std::string WhyNot() const = 0;
  // For the step that was read, on top of its own changes.
  virtual void AddChange(const core::ParameterChange& change) = 0;
  virtual void Step() = 0;

  [[nodiscard]] virtual std::uint64_t recorded_digest() const = 0;  // of the step's outputs
  [[nodiscard]] virtual std::uint64_t digest() const = 0;           // of those that Step made
  [[nodiscard]] virtual std::vector<replay::Leaf> RecordedOutputs() = 0;
  [[nodiscard]] virtual std::vector<replay::Leaf> Outputs() = 0;

  // "physics/state:bodies[3].X_WO.translation.x": the topic that a field of the outputs goes to, and the field.
  [[nodiscard]] virtual std::string NameOf(const std::string& path) const = 0;
  // What people call the thing in that field: an object, a mechanism; or nothing.
  [[nodiscard]] virtual std::string ThingOf(const std::string& path) const = 0;
};

}  // namespace lockstep
