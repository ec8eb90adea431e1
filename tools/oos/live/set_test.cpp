#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "bus/membership/registry.hpp"
#include "bus/node.hpp"
#include "core/clock.hpp"
#include "tools/oos/live/verbs.hpp"

namespace oos {
namespace {

using testing::HasSubstr;

// A session with one node that owns `force_cap_N` and accepts values that are not negative.
class SetVerbTest : public testing::Test {
 protected:
  void SetUp() override {
    auto registry = bus::Registry::Create({"tcp://127.0.0.1:0", 7, "", false});
    ASSERT_TRUE(registry) << registry.error().detail;
    registry_ = std::move(*registry);
    bus::NodeOptions options;
    options.name = "haptic_node";
    options.registry = registry_->endpoint();
    options.session = 7;
    options.is_encrypted = false;
    auto node = bus::Node::Create(options);
    ASSERT_TRUE(node) << node.error().detail;
    node_ = std::move(*node);
    node_->OwnParameters({"force_cap_N"});
    ASSERT_TRUE(node_->Start());
    step_ = std::thread([this] {
      while (!is_done_.load()) {
        node_->Wait(core::MonotonicNow_ns() + core::kTick_ns);
        core::ParameterChange change;
        std::uint64_t ticket = 0;
        while (node_->PollParameter(&change, &ticket)) {
          node_->AckParameter(ticket, 42, change.value >= 0.0, "the value must be 0 or more");
        }
      }
    });
  }
  void TearDown() override {
    is_done_.store(true);
    if (step_.joinable()) step_.join();
  }

  // Exit status; what was printed is in out_ and error_.
  int Set(const std::string& path, const std::string& value) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status =
        RunVerbs({TopicVerb(), TopVerb(), ViewVerb(), SetVerb(), FetchVerb()},
                 {"set", path, value, "--registry", registry_->endpoint(), "--session", "7", "--no_encryption"});
    out_ = testing::internal::GetCapturedStdout();
    error_ = testing::internal::GetCapturedStderr();
    return status;
  }

  std::unique_ptr<bus::Registry> registry_;
  std::unique_ptr<bus::Node> node_;
  std::thread step_;
  std::atomic<bool> is_done_{false};
  std::string out_, error_;
};

TEST_F(SetVerbTest, PrintsTheTickOfAChange) {
  EXPECT_EQ(Set("haptic_node.force_cap_N", "12.5"), kHolds) << error_;
  EXPECT_EQ(out_, "force_cap_N = 12.5, applied at tick 42 of haptic_node\n");
}

TEST_F(SetVerbTest, ListsTheNodesWhenOneIsUnknown) {
  EXPECT_EQ(Set("nonsense.force_cap_N", "1"), kDoesNotHold);
  EXPECT_EQ(error_, "oos set: no node is called 'nonsense'; use one of the known names: 'haptic_node'\n");
  EXPECT_EQ(Set("haptic_nod.force_cap_N", "1"), kDoesNotHold);
  EXPECT_THAT(error_, HasSubstr("did you mean 'haptic_node'?"));
}

TEST_F(SetVerbTest, ListsTheParametersWhenOneIsUnknown) {
  EXPECT_EQ(Set("haptic_node.nonsense", "1"), kDoesNotHold);
  EXPECT_EQ(error_,
            "oos set: parameter nonsense was not set: haptic_node has no parameter 'nonsense'; "
            "use one of the known names: 'force_cap_N'\n");
  EXPECT_EQ(Set("haptic_node.force_cap_N", "-1"), kDoesNotHold);
  EXPECT_THAT(error_, HasSubstr("the value must be 0 or more"));
}

}  // namespace
}  // namespace oos
