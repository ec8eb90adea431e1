#pragma once

#include <memory>
#include <span>
#include <string>

#include "bus/log/mcap_records.hpp"
#include "core/result.hpp"

namespace bus::log {

// Decodes recorded payloads by the descriptors in the recording, so that a recording stays readable when this build's
// messages differ.
class PayloadDecoder {
 public:
  PayloadDecoder();
  ~PayloadDecoder();
  PayloadDecoder(const PayloadDecoder&) = delete;
  PayloadDecoder& operator=(const PayloadDecoder&) = delete;

  // One line of JSON with the fields' proto names. Errors: kUnsupported (no protobuf), kDamaged (descriptor or payload
  // cannot be read).
  core::Result<std::string> ToJson(const Schema& schema, std::span<const std::uint8_t> payload);

  // Where two payloads of one schema differ: paths of fields and both values, one a line ("modified: x_wo[3]: 1 -> 2").
  core::Result<std::string> Difference(const Schema& schema, std::span<const std::uint8_t> a,
                                       std::span<const std::uint8_t> b);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bus::log
