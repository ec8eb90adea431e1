#include "bus/wire/control.hpp"

#include "proto/bus.pb.h"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/quiet_protobuf.hpp"
#include "tests/fuzz/targets.hpp"

namespace fuzz {

// The input as the payload of a sound envelope, as a peer of the session can send it.
void FuzzControl(Input input) {
  QuietProtobuf();
  constexpr std::uint64_t kSession = 7;
  oos::Control control;
  Claim(!bus::detail::DecodeControl(input, kSession, &control), "no envelope, no message");
  if (!control.ParseFromArray(input.data(), static_cast<int>(input.size()))) return;
  const bus::detail::Identity identity{kSession, 1, 2};
  const auto bytes = bus::detail::EncodeControl(identity, bus::detail::ClassOf(control), control);
  oos::Control again;
  Claim(bus::detail::DecodeControl(bytes, kSession, &again), "a message that was written can be read");
  Claim(again.body_case() == control.body_case(), "it is the same message");
  Claim(!bus::detail::DecodeControl(bytes, kSession + 1, &again), "another session's message is refused");
}

}  // namespace fuzz
