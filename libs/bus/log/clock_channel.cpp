#include "bus/log/clock_channel.hpp"

#include "bus/wire/schema.hpp"
#include "proto/recording.pb.h"

namespace bus::log {

core::Result<void> ClockChannel::Write(const std::string& node, const std::vector<PeerClock>& clocks,
                                       std::int64_t now_ns, McapWriter* to) {
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
      const std::uint16_t schema = to->AddSchema("oos.ClockSample", "protobuf", ToBytes(descriptors));
      channel_ = to->AddChannel(schema, "clock/" + node, "protobuf", {{"writer", node}, {"tap", "clock"}});
    }
    const auto time_ns = static_cast<std::uint64_t>(now_ns);
    const Message message{*channel_, ++num_samples_, time_ns, time_ns, ToBytes(sample.SerializeAsString())};
    if (auto done = to->Write(message); !done) return done;
  }
  return {};
}

}  // namespace bus::log
