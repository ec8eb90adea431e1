#include "bus/latest/history.hpp"

#include <cstring>

namespace bus::detail {
namespace {

struct [[gnu::packed]] BlockHead {
  std::uint16_t payload_bytes;
  std::uint8_t direct_stamps;
  std::uint8_t other_stamps;
  std::uint16_t steps_back;
  std::int64_t publish_ns;
  std::uint64_t direct_id;
  std::int64_t direct_origin_ns;
  std::uint64_t other_id;
  std::int64_t other_origin_ns;
};
static_assert(sizeof(BlockHead) == 46);
constexpr std::size_t kStepsBackAt = 4;

std::uint8_t* PutStamps(const core::Trace& trace, std::uint8_t* out) {
  for (const core::Stamp& stamp : trace.stamps) {
    std::memcpy(out, &stamp.offset_ns, sizeof(stamp.offset_ns));
    out[4] = static_cast<std::uint8_t>(stamp.stage);
    out += kStampBytes;
  }
  return out;
}

const std::uint8_t* GetStamps(const std::uint8_t* in, std::size_t count, core::Trace* trace) {
  trace->stamps.clear();
  for (std::size_t i = 0; i < count; ++i, in += kStampBytes) {
    std::int32_t offset_ns = 0;
    std::memcpy(&offset_ns, in, sizeof(offset_ns));
    trace->stamps.push_back({static_cast<core::Stage>(in[4]), offset_ns});
  }
  return in;
}

}  // namespace

std::size_t EarlierSamples::Write(std::uint64_t sequence, std::uint8_t* out, std::size_t room) const noexcept {
  std::size_t written = 0;
  for (std::uint64_t back = 1; back <= kMaxEarlierSamples && back < sequence; ++back) {
    const Block& block = blocks_[(sequence - back) % kMaxEarlierSamples];
    if (block.sequence != sequence - back || written + block.size > room) continue;
    std::memcpy(out + written, block.bytes.data(), block.size);
    const auto steps_back = static_cast<std::uint16_t>(back);
    std::memcpy(out + written + kStepsBackAt, &steps_back, sizeof(steps_back));
    written += block.size;
  }
  return written;
}

void EarlierSamples::Keep(const core::Header& header, std::span<const std::uint8_t> payload) noexcept {
  const std::size_t size = sizeof(BlockHead) + EnvelopeBytes(header) - kEnvelopeFixedBytes + payload.size();
  if (size > kMaxEarlierBytes) return;
  Block& block = blocks_[header.sequence % kMaxEarlierSamples];
  block.sequence = header.sequence;
  block.size = size;
  const BlockHead head{static_cast<std::uint16_t>(payload.size()),
                       static_cast<std::uint8_t>(header.direct.stamps.size()),
                       static_cast<std::uint8_t>(header.through_physics.stamps.size()),
                       0,
                       header.publish_ns,
                       header.direct.id,
                       header.direct.origin_ns,
                       header.through_physics.id,
                       header.through_physics.origin_ns};
  std::memcpy(block.bytes.data(), &head, sizeof(head));
  std::uint8_t* out = PutStamps(header.direct, block.bytes.data() + sizeof(head));
  out = PutStamps(header.through_physics, out);
  std::memcpy(out, payload.data(), payload.size());
}

bool NextEarlierSample(std::uint64_t sequence, std::span<const std::uint8_t>* blocks, EarlierSample* sample) noexcept {
  BlockHead head;
  if (blocks->size() < sizeof(head)) return false;
  std::memcpy(&head, blocks->data(), sizeof(head));
  const std::size_t stamps = std::size_t{head.direct_stamps} + head.other_stamps;
  const std::size_t size = sizeof(head) + kStampBytes * stamps + head.payload_bytes;
  if (size > blocks->size() || head.direct_stamps > core::kMaxStamps || head.other_stamps > core::kMaxStamps ||
      head.steps_back == 0 || head.steps_back >= sequence) {
    return false;
  }
  core::Header& header = sample->header;
  header.sequence = sequence - head.steps_back;
  header.publish_ns = head.publish_ns;
  header.direct.id = head.direct_id;
  header.direct.origin_ns = head.direct_origin_ns;
  header.through_physics.id = head.other_id;
  header.through_physics.origin_ns = head.other_origin_ns;
  const std::uint8_t* in = GetStamps(blocks->data() + sizeof(head), head.direct_stamps, &header.direct);
  in = GetStamps(in, head.other_stamps, &header.through_physics);
  sample->payload = {in, head.payload_bytes};
  *blocks = blocks->subspan(size);
  return true;
}

}  // namespace bus::detail
