#include "nodes/visual_node/window/space_mouse.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <spnav.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>

namespace visual_node {
namespace {

// A daemon that speaks the first version of spacenavd's protocol: an event is eight 32-bit numbers, of a motion
// 0, x, y, z, rx, ry, rz, period, of a button 1 (pressed) or 2, and its number.
class Daemon {
 public:
  explicit Daemon(std::string path) : path_(std::move(path)) {
    listener_ = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path_.c_str(), sizeof address.sun_path - 1);
    unlink(path_.c_str());
    EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
  }
  ~Daemon() {
    close(listener_);
    if (client_ >= 0) close(client_);
    unlink(path_.c_str());
  }
  void Accept() { client_ = accept(listener_, nullptr, nullptr); }
  void Send(const std::array<std::int32_t, 8>& event) const {
    EXPECT_EQ(write(client_, event.data(), sizeof event), static_cast<ssize_t>(sizeof event));
  }

 private:
  std::string path_;
  int listener_ = -1, client_ = -1;
};

class SpaceMouseTest : public testing::Test {
 protected:
  SpaceMouseTest() : path_(testing::TempDir() + "spnav_" + std::to_string(getpid())) {
    setenv("SPNAV_SOCKET", path_.c_str(), 1);
  }
  ~SpaceMouseTest() override { unsetenv("SPNAV_SOCKET"); }

  // Reads until that is so; a socket of one machine delivers at once.
  view::SteeringWish ReadUntil(const std::function<bool(const view::SteeringWish&)>& is_so) {
    view::SteeringWish wish;
    for (int i = 0; i < 1000; ++i) {
      wish = {};
      mouse_.Read(now_s_ += 0.01, &wish);
      if (is_so(wish)) return wish;
      poll(nullptr, 0, 1);
    }
    ADD_FAILURE() << "not within a second";
    return wish;
  }

  std::string path_;
  SpaceMouse mouse_;
  double now_s_ = 0.0;
};

TEST_F(SpaceMouseTest, IsNotThereWithoutADaemon) {
  view::SteeringWish wish;
  mouse_.Read(now_s_, &wish);
  EXPECT_FALSE(mouse_.is_there());
  EXPECT_FALSE(wish.is_held);
}

TEST_F(SpaceMouseTest, PushesAndTurnsAlongThePicturesAxes) {
  Daemon daemon(path_);
  ReadUntil([this](const view::SteeringWish&) { return mouse_.is_there(); });
  daemon.Accept();
  daemon.Send({0, 350, 70, -35, 0, 175, 7000, 16});
  const view::SteeringWish wish = ReadUntil([](const view::SteeringWish& w) { return w.is_held; });
  EXPECT_EQ(wish.push.x, 1.0);
  EXPECT_DOUBLE_EQ(wish.push.y, 0.2);
  EXPECT_DOUBLE_EQ(wish.push.z, -0.1);
  EXPECT_EQ(wish.turn.x, 0.0);
  EXPECT_DOUBLE_EQ(wish.turn.y, 0.5);
  EXPECT_EQ(wish.turn.z, 1.0) << "no more than a key";
  daemon.Send({0, 0, 0, 0, 0, 0, 0, 16});
  ReadUntil([](const view::SteeringWish& w) { return !w.is_held; });
  daemon.Send({1, 0, 0, 0, 0, 0, 0, 0});
  daemon.Send({2, 0, 0, 0, 0, 0, 0, 0});
  int presses = 0;
  ReadUntil([&](const view::SteeringWish&) { return (presses += mouse_.TakeLeftPresses()) == 1; });
  EXPECT_EQ(mouse_.TakeRightPresses(), 0);
}

// As libspnav itself moves an object in OpenGL's frame, whose z is to the person.
TEST_F(SpaceMouseTest, AgreesWithTheLibraryOnWhatIsAway) {
  spnav_event_motion motion{};
  motion.z = 100;
  spnav_posrot posrot{};
  spnav_posrot_init(&posrot);
  spnav_posrot_moveobj(&posrot, &motion);
  EXPECT_LT(posrot.pos[2], 0.0);
}

TEST_F(SpaceMouseTest, LetsGoWhenItsDaemonEndsAndComesBackWithIt) {
  {
    Daemon daemon(path_);
    ReadUntil([this](const view::SteeringWish&) { return mouse_.is_there(); });
    daemon.Accept();
    daemon.Send({0, 350, 0, 0, 0, 0, 0, 16});
    ReadUntil([](const view::SteeringWish& w) { return w.is_held; });
  }
  ReadUntil([this](const view::SteeringWish& w) { return !mouse_.is_there() && !w.is_held; });
  Daemon again(path_);
  ReadUntil([this](const view::SteeringWish&) { return mouse_.is_there(); });
}

}  // namespace
}  // namespace visual_node
