#include "bus/testing/soak.hpp"

namespace bus {
namespace {

// "Accounting": exact after ten minutes of loss, restarts and a slow subscriber.
TEST(Soak, AccountsCloseAfterTenMinutesOfTrouble) {
  testing::RunSoak(600 * core::kNanosecondsPerSecond);
}

}  // namespace
}  // namespace bus
