#pragma once

#include <cstdint>

#include "bus/log/step_sink.hpp"
#include "replay/difference.hpp"
#include "replay/fields.hpp"
#include "replay/step_codec.hpp"

namespace replay {

// Records the inputs and outputs of a node's step. Step describes both (step.hpp in the node's folder), with
//   template <class V> void VisitInputs(V&, Step&)   and   VisitOutputs(V&, Step&)
// Record neither locks nor allocates.
template <class Step>
class StepRecorder {
 public:
  static constexpr std::size_t kMaxFields = 65536;  // some 60 times the thousand fields of a usual step

  explicit StepRecorder(bus::log::StepSink* sink, std::uint8_t kind = kUsualStep)
      : sink_(sink), encoder_(kMaxFields, kind) {}

  void Record(std::uint64_t tick, std::int64_t now_ns, Step& step) noexcept {
    Digest digest;
    digest.includes_transport = false;
    VisitOutputs(digest, step);
    encoder_.Begin(tick);
    encoder_.includes_transport = true;
    VisitInputs(encoder_, step);
    encoder_.includes_transport = false;
    VisitOutputs(encoder_, step);
    const auto bytes = encoder_.Finish(digest.value());
    if (bytes.empty() || !sink_->Push(tick, now_ns, bytes)) encoder_.Forget();
  }

 private:
  bus::log::StepSink* sink_;
  StepEncoder encoder_;
};

}  // namespace replay
