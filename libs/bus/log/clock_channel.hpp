#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bus/log/mcap_writer.hpp"
#include "bus/log/tap.hpp"
#include "bus/schema.hpp"
#include "proto/recording.pb.h"

namespace bus::log {

// "clock/<node>" of a recording: what the node knows of its peers' clocks, now and then.
class ClockChannel {
 public:
  static constexpr std::int64_t kPeriod_ns = 500'000'000;

  [[nodiscard]] bool is_due(std::int64_t now_ns) const { return now_ns - written_ns_ >= kPeriod_ns; }

  core::Result<void> Write(const std::string& node, const std::vector<PeerClock>& clocks, std::int64_t now_ns,
                           McapWriter* to) {
    written_ns_ = now_ns;
    for (const PeerClock& clock : clocks) {
      oos::ClockSample sample;
      sample.set_peer(clock.peer);
      sample.set_peer_machine(clock.machine);
      sample.set_offset_ns(clock.offset_ns);
      sample.set_bound_ns(clock.bound_ns);
      sample.set_drift(clock.drift);
      if (!channel_) {
        const std::string descriptors = DescriptorSetOf(*oos::ClockSample::descriptor());
        const std::uint16_t schema =
            to->AddSchema("oos.ClockSample", "protobuf", Bytes(descriptors.begin(), descriptors.end()));
        channel_ = to->AddChannel(schema, "clock/" + node, "protobuf", {{"writer", node}, {"tap", "clock"}});
      }
      const std::string text = sample.SerializeAsString();
      const auto time_ns = static_cast<std::uint64_t>(now_ns);
      const Message message{*channel_, ++num_samples_, time_ns, time_ns, Bytes(text.begin(), text.end())};
      if (auto done = to->Write(message); !done) return done;
    }
    return {};
  }

  // Another file from here on.
  void BeginFile() { channel_.reset(); }

 private:
  std::optional<std::uint16_t> channel_;
  std::uint32_t num_samples_ = 0;
  std::int64_t written_ns_ = 0;
};

}  // namespace bus::log
