#include "bus/testing/soak.hpp"

namespace bus {
namespace {

TEST(Soak, AccountsCloseAfterSecondsOfTrouble) {
  testing::RunSoak(6 * core::kNanosecondsPerSecond);
}

}  // namespace
}  // namespace bus
