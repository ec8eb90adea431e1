#include "core/messages/haptic.hpp"
#include "replay/fields.hpp"
#include "replay/step_codec.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {

// Steps of a recording, one after the other.
void FuzzStep(Input input) {
  Reader reader(input);
  replay::StepDecoder decoder;
  core::PhysicsState state;
  core::ContactSet contacts;
  core::LogicStatus status;
  while (!reader.is_at_end()) {
    const Input step = reader.Piece();
    if (!decoder.Begin(step)) continue;
    replay::Visit(decoder, state);
    replay::Visit(decoder, contacts);
    replay::Visit(decoder, status);
    if (!decoder.Finish()) continue;
    replay::StepEncoder encoder(std::size_t{1} << 16);
    encoder.Begin(decoder.tick());
    replay::Visit(encoder, state);
    replay::Visit(encoder, contacts);
    replay::Visit(encoder, status);
    Claim(!encoder.Finish(decoder.digest()).empty(), "a step that was read can be written");
  }
}

}  // namespace fuzz
