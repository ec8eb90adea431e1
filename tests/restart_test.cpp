#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "nodes/physics_node/physics_node.hpp"
#include "tests/support.hpp"

namespace system_tests {
namespace {

struct TickRun {
  lockstep::Outcome outcome;
  std::vector<std::uint64_t> hashes;  // of physics, per tick
  std::uint64_t first_contact = 0;    // tick
};

TickRun Follow(const scene::Scenario& scenario, lockstep::Options options) {
  TickRun run;
  options.follow = [&run](const core::PhysicsState& state) {
    run.hashes.push_back(state.state_hash);
    if (state.is_in_contact && run.first_contact == 0) run.first_contact = state.tick;
  };
  run.outcome = InLockstep(scenario, options);
  return run;
}

std::filesystem::path CheckpointFile(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / (name + ".checkpoint");
}

void ExpectSameTicks(const TickRun& a, const TickRun& b) {
  for (std::size_t i = 0; i < std::min(a.hashes.size(), b.hashes.size()); ++i) {
    ASSERT_EQ(a.hashes[i], b.hashes[i]) << "tick " << i + 1;
  }
  EXPECT_EQ(a.hashes.size(), b.hashes.size());
  EXPECT_EQ(a.outcome.hash, b.outcome.hash);
}

// Physics ends during contact and grasp; restored from the checkpoint file alone, it continues bit for bit.
TEST(Restart, FromACheckpointEveryTickEqualsTheUninterruptedRun) {
  struct Case {
    const char* scenario;
    std::uint64_t ticks_after_contact;  // few: the solver's warm start matters; many: an object is being held
  };
  for (const Case& c : {Case{"touch", 300}, Case{"peg_in_hole", 2500}, Case{"free_collision", 5}}) {
    SCOPED_TRACE(c.scenario);
    const scene::Scenario scenario = Load(c.scenario);
    lockstep::Options options;
    const TickRun whole = Follow(scenario, options);
    ASSERT_GT(whole.first_contact, 0u);
    options.restart_physics_tick = whole.first_contact + c.ticks_after_contact;
    ASSERT_LT(options.restart_physics_tick + 500, whole.hashes.size());
    options.checkpoint = CheckpointFile(c.scenario);
    ExpectSameTicks(whole, Follow(scenario, options));
  }
}

TEST(Restart, OneTwoAndFourWorkersGiveTheSameTicks) {
  for (const char* name : {"peg_in_hole", "free_collision"}) {
    SCOPED_TRACE(name);
    const scene::Scenario scenario = Load(name);
    lockstep::Options options;
    options.duration_s = 3.0;
    const TickRun one = Follow(scenario, options);
    for (const unsigned workers : {2u, 4u}) {
      options.workers = workers;
      ExpectSameTicks(one, Follow(scenario, options));
    }
  }
}

TEST(Restart, ADamagedOrForeignCheckpointIsRefusedWithOneReason) {
  const auto node = physics_node::PhysicsNode::Create(Load("touch"));
  ASSERT_TRUE(node.has_value());
  const std::uint64_t content = (*node)->content_digest();
  physics_node::Snapshot snapshot;
  (*node)->Save(&snapshot);
  const auto file = CheckpointFile("refused");
  ASSERT_TRUE(physics_node::WriteSnapshot(file, content, snapshot).has_value());
  std::string good;
  {
    std::ifstream in(file, std::ios::binary);
    good.assign(std::istreambuf_iterator<char>(in), {});
  }
  const auto complaint = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    physics_node::Snapshot read;
    const auto result = physics_node::ReadSnapshot(file, content, &read);
    return result ? std::string() : result.error().detail;
  };
  EXPECT_EQ(complaint(good), "");
  EXPECT_NE(complaint("").find("is not a checkpoint"), std::string::npos);
  EXPECT_NE(complaint("<scenario/>").find("is not a checkpoint"), std::string::npos);
  for (const std::size_t at : {std::size_t{20}, good.size() / 2, good.size() - 1}) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    EXPECT_NE(complaint(bad).find("damaged"), std::string::npos) << at;
  }
  EXPECT_NE(complaint(good.substr(0, good.size() - 8)).find("damaged"), std::string::npos);
  std::string newer = good;
  newer[8] = 99;
  EXPECT_NE(complaint(newer).find("format 99"), std::string::npos);

  const auto other = physics_node::PhysicsNode::Create(Load("peg_in_hole"));
  ASSERT_TRUE(other.has_value());
  ASSERT_TRUE(physics_node::WriteSnapshot(file, (*other)->content_digest(), snapshot).has_value());
  EXPECT_NE(complaint([&] {
              std::ifstream in(file, std::ios::binary);
              return std::string(std::istreambuf_iterator<char>(in), {});
            }())
                .find("another scenario"),
            std::string::npos);
  EXPECT_FALSE((*other)->Restore(&snapshot).has_value());
}

}  // namespace
}  // namespace system_tests
