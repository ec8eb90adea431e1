#pragma once

#include <memory>
#include <span>
#include <string>

#include "bus/log/mcap_records.hpp"
#include "core/result.hpp"

namespace bus::log {

// Reads recorded payloads by the descriptors that the recording carries, so that a recording stays readable whatever
// this build's messages look like.
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
