#include "tools/transport_peers/lcm_channel.hpp"

#include <lcm/lcm.h>

#include <cstring>
#include <string>
#include <vector>

#include "core/clock.hpp"

namespace transport_peers {
namespace {

constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";

class LcmChannel final : public transport::Channel {
 public:
  LcmChannel(std::size_t num_bytes, lcm_t* near, lcm_t* far)
      : Channel("LCM", num_bytes),
        near_(near),
        far_(far),
        topic_("bench" + std::to_string(num_bytes)),
        out_(num_bytes) {
    lcm_subscribe(far_, topic_.c_str(), Take, this);
  }
  ~LcmChannel() override {
    lcm_destroy(near_);
    lcm_destroy(far_);
  }
  bool Send(std::int64_t now_ns) override {
    std::memcpy(out_.data(), &now_ns, sizeof(now_ns));
    return lcm_publish(near_, topic_.c_str(), out_.data(), static_cast<unsigned>(out_.size())) == 0;
  }
  std::int64_t Receive() override {
    sent_ns_ = 0;
    lcm_handle_timeout(far_, transport::kPatience_ms);
    return sent_ns_;
  }

 private:
  static void Take(const lcm_recv_buf_t* got, const char*, void* user) {
    if (got->data_size >= sizeof(std::int64_t)) {
      std::memcpy(&static_cast<LcmChannel*>(user)->sent_ns_, got->data, sizeof(std::int64_t));
    }
  }

  lcm_t *near_, *far_;
  std::string topic_;
  std::vector<std::uint8_t> out_;
  std::int64_t sent_ns_ = 0;
};

}  // namespace

std::unique_ptr<transport::Channel> MakeLcm(std::size_t num_bytes) {
  lcm_t* const near = lcm_create(kUrl);
  lcm_t* const far = lcm_create(kUrl);
  if (near == nullptr || far == nullptr) {
    if (near != nullptr) lcm_destroy(near);
    if (far != nullptr) lcm_destroy(far);
    return nullptr;
  }
  auto channel = std::make_unique<LcmChannel>(num_bytes, near, far);
  // Without a route for multicast no message ever arrives.
  for (int attempt = 0; attempt < 20; ++attempt) {
    channel->Send(core::MonotonicNow_ns());
    if (channel->Receive() != 0) return channel;
  }
  return nullptr;
}

}  // namespace transport_peers
