#pragma once

#include <cstdint>

#include "bus/log/step_sink.hpp"
#include "replay/difference.hpp"
#include "replay/fields.hpp"
#include "replay/step_codec.hpp"

namespace replay {

// Writes down what a node's step read and made. Step is the node's description of both (step.hpp of its folder), with
//   template <class V> void VisitInputs(V&, Step&)   and   VisitOutputs(V&, Step&)
// Record neither locks nor allocates.
template <class Step>
class StepRecorder {
 public:
  static constexpr std::size_t kMaxFields = 65536;

  explicit StepRecorder(bus::log::StepSink* sink) : sink_(sink), encoder_(kMaxFields) {}

  void Record(std::uint64_t tick, std::int64_t now_ns, Step& step) noexcept {
    Digest digest;
    digest.tells_transport = false;
    VisitOutputs(digest, step);
    encoder_.Begin(tick);
    encoder_.tells_transport = true;
    VisitInputs(encoder_, step);
    encoder_.tells_transport = false;
    VisitOutputs(encoder_, step);
    const auto bytes = encoder_.Finish(digest.value());
    if (bytes.empty() || !sink_->Push(tick, now_ns, bytes)) encoder_.Forget();
  }

 private:
  bus::log::StepSink* sink_;
  StepEncoder encoder_;
};

}  // namespace replay
