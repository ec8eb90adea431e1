// A viewer and its workers on three machines whose links lose one packet in a hundred.

#include <nlohmann/json.hpp>

#include "bus/accounts/reported_accounts.hpp"
#include "tests/lab/survive.hpp"

namespace system_tests {
namespace {

class RaysInALab : public SurviveTest {
 protected:
  // False: this kernel cannot.
  static bool LosePackets(int per_mille) {
    const std::string rules =
        "add table inet test; add chain inet test in { type filter hook input priority 0; }; "
        "add rule inet test in meta l4proto { tcp, udp } numgen random mod 1000 < " +
        std::to_string(per_mille) + " counter drop";
    for (const char* machine : {"alpha", "beta", "gamma"}) {
      const auto answer = process::RunHere(machines_->InNetworkOf(machine, {"nft", rules}));
      if (!answer || !answer->is_good()) return false;
    }
    return true;
  }
  // How many packets of that machine have been lost so far.
  static double NumLost(const char* machine) {
    const auto answer =
        process::RunHere(machines_->InNetworkOf(machine, {"nft", "-j", "list", "table", "inet", "test"}));
    if (!answer || !answer->is_good()) return 0.0;
    const auto listed = nlohmann::json::parse(answer->out, nullptr, false);
    for (const auto& part : listed.value("nftables", nlohmann::json::array())) {
      if (!part.contains("rule")) continue;
      for (const auto& step : part["rule"]["expr"]) {
        if (step.contains("counter")) return step["counter"]["packets"].get<double>();
      }
    }
    return 0.0;
  }
  static void MendLinks() {
    for (const char* machine : {"alpha", "beta", "gamma"}) {
      process::RunHere(machines_->InNetworkOf(machine, {"nft", "delete table inet test"}));
    }
  }
  // By the log of a viewer that has ended.
  void ExpectCompleteFrames(const std::string& viewer, unsigned long long wanted_workers) {
    std::ifstream log(out_ / (viewer + ".log"));
    unsigned long long complete = 0, begun = 0, workers = 0;
    for (std::string line; std::getline(log, line);) {
      const char* const format = "%llu of %llu frames complete, by %llu workers";
      if (std::sscanf(line.c_str(), format, &complete, &begun, &workers) == 3) break;
    }
    EXPECT_EQ(workers, wanted_workers) << viewer << ": none was taken for dead at the end";
    EXPECT_GT(complete, 50u) << viewer;
    EXPECT_LE(begun - complete, 2u) << viewer << ": those in flight at the end; else a picture has stood still";
  }
  void TearDown() override {
    MendLinks();
    SurviveTest::TearDown();
  }
};

TEST_F(RaysInALab, EveryPictureIsCompleteOverLinksThatLosePackets) {
  const std::string lab = WriteLab("rays", OnThree());
  std::string text;
  {
    std::ifstream in(lab);
    text.assign(std::istreambuf_iterator<char>(in), {});
  }
  std::ofstream(lab) << text.replace(
      text.find("</lab>\n"), 7,
      "  <ray_workers host=\"alpha\"/>\n  <ray_workers host=\"beta\"/>\n"
      "  <view name=\"teacher\" host=\"gamma\" renderer=\"rays\" size=\"64x64\"/>\n</lab>\n");
  StartRun("rays", {}, lab);
  if (HasFatalFailure()) return;
  if (!LosePackets(10)) {
    FinishRun();
    GTEST_SKIP() << "this kernel has no nftables for namespaces";
  }
  bus::ReportedAccounts books;
  EXPECT_TRUE(Until(
      [&] {
        books.Update(watch_->peers());
        return watch_->is_final();
      },
      120.0));
  EXPECT_GT(books.num_compared(), 10u);
  EXPECT_TRUE(books.Disagreements().empty()) << books.Disagreements().front();
  for (const char* machine : {"alpha", "beta", "gamma"}) EXPECT_GT(NumLost(machine), 100.0) << machine;
  MendLinks();
  FinishRun();
  std::ifstream in(out_ / "visual_node.json");
  const auto seen = nlohmann::json::parse(in, nullptr, false);
  ASSERT_TRUE(seen.is_object());
  std::printf("%.0f pictures, %.1f per second; the slowest took %.0f ms\n", seen["frames"].get<double>(),
              seen["fps"].get<double>(), seen["draw_ms"]["max"].get<double>());
  EXPECT_GT(seen["frames"].get<double>(), 50.0);
  ExpectCompleteFrames("visual_node", 2);
  // A viewer of the lab file, with a worker of its own.
  std::ifstream worker(out_ / "rt_worker-visual_node-teacher-1.log");
  unsigned long long tiles = 0;
  for (std::string line; std::getline(worker, line);) std::sscanf(line.c_str(), "%llu tiles", &tiles);
  EXPECT_GT(tiles, 50u);
}

}  // namespace
}  // namespace system_tests
