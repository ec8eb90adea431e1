#include "tools/oos/doctor/doctor_network.hpp"

#include <gtest/gtest.h>

namespace oos {
namespace {

TEST(JudgeInterface, WarnsWhenTheLargestDatagramDoesNotFit) {
  Interface interface { "eth1", "10.0.0.1", 1228, 1000, 0 };
  EXPECT_EQ(JudgeInterface(interface).grade, Grade::kOk);
  interface.mtu = 1227;
  const Finding finding = JudgeInterface(interface);
  EXPECT_EQ(finding.grade, Grade::kFail);
  EXPECT_NE(finding.remedy.find("ip link set eth1 mtu"), std::string::npos);
}

TEST(JudgeInterface, ReportsLossWithItsShare) {
  const Finding finding = JudgeInterface({"eth1", "10.0.0.1", 1500, 1000, 20});
  EXPECT_EQ(finding.grade, Grade::kWarn);
  EXPECT_NE(finding.what.find("2.00 % of 1000"), std::string::npos) << finding.what;
  EXPECT_FALSE(finding.remedy.empty());
}

TEST(JudgeBuffer, ReportsEachOfTheTwoLimits) {
  EXPECT_EQ(JudgeBuffer(Buffer::kReceive, 1 << 20).grade, Grade::kOk);
  EXPECT_EQ(JudgeBuffer(Buffer::kSend, 1 << 20).grade, Grade::kOk);
  const Finding receive = JudgeBuffer(Buffer::kReceive, 212992), send = JudgeBuffer(Buffer::kSend, 212992);
  EXPECT_EQ(receive.grade, Grade::kWarn);
  EXPECT_NE(receive.remedy.find("net.core.rmem_max = 1048576"), std::string::npos) << receive.remedy;
  EXPECT_EQ(send.grade, Grade::kWarn);
  EXPECT_NE(send.remedy.find("net.core.wmem_max = 1048576"), std::string::npos) << send.remedy;
}

bus::PeerStatus Peer() {
  bus::PeerStatus peer;
  peer.name = "haptic_node";
  peer.is_alive = true;
  peer.udp_endpoint = "10.0.0.2:40000";
  peer.accounts = {{"physics/state", "physics_node", false, 1000, 1000, 0},
                   {"event", "physics_node", false, 10, 0, 10}};  // events have their own findings
  return peer;
}

TEST(JudgePeer, AHealthyNodeNeedsNoRemedy) {
  const Finding finding = JudgePeer(Peer());
  EXPECT_EQ(finding.grade, Grade::kOk);
  EXPECT_TRUE(finding.remedy.empty());
}

TEST(JudgePeer, ReportsEveryProblemWithARemedy) {
  struct Case {
    const char* what;
    void (*spoil)(bus::PeerStatus*);
  };
  const Case cases[] = {
      {"silent", [](bus::PeerStatus* peer) { peer->is_alive = false; }},
      {"stands still", [](bus::PeerStatus* peer) { peer->is_stalled = true; }},
      {"clock is not known", [](bus::PeerStatus* peer) { peer->clock_bound_ns = INT64_MAX; }},
      {"within 2.000 ms, round trip at most 4.000 ms", [](bus::PeerStatus* peer) { peer->clock_bound_ns = 2'000'000; }},
      {"5.00 % of 1000", [](bus::PeerStatus* peer) { peer->accounts[0].dropped = 50; }},
  };
  for (const Case& it : cases) {
    bus::PeerStatus peer = Peer();
    it.spoil(&peer);
    const Finding finding = JudgePeer(peer);
    EXPECT_NE(finding.grade, Grade::kOk) << it.what;
    EXPECT_NE(finding.what.find(it.what), std::string::npos) << finding.what;
    EXPECT_FALSE(finding.remedy.empty()) << it.what;
  }
}

}  // namespace
}  // namespace oos
