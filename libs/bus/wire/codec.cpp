#include "bus/wire/codec.hpp"

#include "bus/wire/decode.hpp"
#include "bus/wire/encode.hpp"

namespace bus {

template <class M>
int LatestCodec<M>::NumParts(const M& message, std::size_t budget) const noexcept {
  return detail::CountParts(message, budget);
}

template <class M>
std::size_t LatestCodec<M>::Encode(const M& message, int part, std::size_t budget, std::uint8_t* out,
                                   std::size_t capacity) const noexcept {
  const detail::Part<M> held = detail::PartOf(message, part, budget);
  const std::size_t size = detail::CountBytes(message, held);
  if (size > capacity) return kDoesNotFit;
  detail::WireWriter writer(out);
  detail::WriteFields(message, held, &writer);
  return size;
}

template <class M>
bool LatestCodec<M>::Decode(std::span<const std::uint8_t> payload, bool is_first, M* message) const noexcept {
  return detail::DecodeMessage(payload, is_first, message);
}

template <class M>
void EncodeState(const M& value, std::string* bytes) {
  const detail::Part<M> whole = detail::WholeOf(value);
  bytes->resize(detail::CountBytes(value, whole));
  detail::WireWriter writer(reinterpret_cast<std::uint8_t*>(bytes->data()));
  detail::WriteFields(value, whole, &writer);
}

template <class M>
bool DecodeState(const std::string& bytes, M* value) {
  return detail::DecodeMessage({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, true, value);
}

#define LATEST_CODEC(Message) template class LatestCodec<core::Message>;
BUS_LATEST_MESSAGES(LATEST_CODEC)
#define STATE_CODEC(Message)                                     \
  template void EncodeState(const core::Message&, std::string*); \
  template bool DecodeState(const std::string&, core::Message*);
BUS_RELIABLE_MESSAGES(STATE_CODEC)

}  // namespace bus
