#include "replay/step_codec.hpp"

#include <algorithm>

namespace replay {
namespace {

constexpr std::size_t kTextBytes = 8;  // of a text in one field

template <class T>
T Read(std::span<const std::uint8_t> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

}  // namespace

StepEncoder::StepEncoder(std::size_t max_fields, std::uint8_t kind)
    : last_(max_fields),
      flags_((max_fields + 7) / 8),
      values_(9 * max_fields + sizeof(std::uint64_t)),
      step_(kStepHeadBytes + flags_.size() + values_.size()),
      kind_(kind) {}

void StepEncoder::Begin(std::uint64_t tick) {
  is_key_ = is_key_next_ || since_key_ + 1 >= kKeyPeriod;
  is_key_next_ = false;
  since_key_ = is_key_ ? 0 : since_key_ + 1;
  std::fill_n(flags_.begin(), std::min(flags_.size(), (num_fields_ + 7) / 8), std::uint8_t{0});
  num_fields_ = num_value_bytes_ = 0;
  tick_ = tick;
}

std::span<const std::uint8_t> StepEncoder::Finish(std::uint64_t digest) {
  if (num_fields_ > last_.size()) {
    last_fields_ = 0;
    is_key_next_ = true;
    return {};
  }
  const std::size_t num_flag_bytes = (num_fields_ + 7) / 8;
  const auto fields = static_cast<std::uint32_t>(num_fields_);
  std::memset(step_.data(), 0, 4);
  step_[0] = is_key_ ? 1 : 0;
  step_[1] = kind_;
  std::memcpy(&step_[4], &fields, sizeof fields);
  std::memcpy(&step_[8], &tick_, sizeof tick_);
  std::memcpy(&step_[16], &digest, sizeof digest);
  std::memcpy(&step_[kStepHeadBytes], flags_.data(), num_flag_bytes);
  std::memcpy(&step_[kStepHeadBytes + num_flag_bytes], values_.data(), num_value_bytes_);
  last_fields_ = num_fields_;
  return std::span(step_).first(kStepHeadBytes + num_flag_bytes + num_value_bytes_);
}

void StepEncoder::Text(std::string_view, std::string& text) {
  Put(text.size());
  for (std::size_t at = 0; at < text.size(); at += kTextBytes) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, text.data() + at, std::min(kTextBytes, text.size() - at));
    Put(bits);
  }
}

bool StepDecoder::Begin(std::span<const std::uint8_t> step) {
  is_damaged_ = true;
  if (step.size() < kStepHeadBytes) return false;
  const std::size_t num_fields = Read<std::uint32_t>(step, 4);
  const std::size_t num_flag_bytes = (num_fields + 7) / 8;
  if (step[0] > 1 || step.size() < kStepHeadBytes + num_flag_bytes) return false;
  if (step[0] == 0 && !has_key_) return false;
  has_key_ = true;
  tick_ = Read<std::uint64_t>(step, 8);
  digest_ = Read<std::uint64_t>(step, 16);
  flags_ = step.subspan(kStepHeadBytes, num_flag_bytes);
  values_ = step.subspan(kStepHeadBytes + num_flag_bytes);
  if (step[0] == 1) last_.clear();
  last_.resize(num_fields);
  next_ = at_ = 0;
  is_damaged_ = false;
  return true;
}

std::uint64_t StepDecoder::Take() {
  if (is_damaged_ || next_ >= last_.size()) {
    is_damaged_ = true;
    return 0;
  }
  const std::size_t i = next_++;
  if ((flags_[i / 8] >> (i % 8) & 1U) == 0) return last_[i];
  const std::size_t used = at_ < values_.size() ? values_[at_] : 9;
  if (used > 8 || at_ + 1 + used > values_.size()) {
    is_damaged_ = true;
    return 0;
  }
  std::uint64_t bits = 0;
  std::memcpy(&bits, values_.data() + at_ + 1, used);
  at_ += 1 + used;
  return last_[i] ^= bits;
}

bool StepDecoder::Finish() {
  const bool is_whole = !is_damaged_ && next_ == last_.size() && at_ == values_.size();
  if (!is_whole) has_key_ = false;
  return is_whole;
}

void StepDecoder::Text(std::string_view, std::string& text) {
  const std::uint64_t size = Take();
  if (size > kTextBytes * last_.size()) {
    Fail();
    return;
  }
  text.resize(static_cast<std::size_t>(size));
  for (std::size_t at = 0; at < text.size(); at += kTextBytes) {
    const std::uint64_t bits = Take();
    std::memcpy(text.data() + at, &bits, std::min(kTextBytes, text.size() - at));
  }
}

}  // namespace replay
