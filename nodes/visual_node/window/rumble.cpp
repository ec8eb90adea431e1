#include "nodes/visual_node/window/rumble.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace visual_node {
namespace {

constexpr const char* kFolder = "/dev/input";
constexpr double kLength_s = 0.4;   // of an effect: who has died shakes no longer
constexpr double kPeriod_s = 0.15;  // between two effects of the same strength
constexpr double kStep = 0.05;      // of strength, that a hand notices

template <std::size_t N>
bool HasBit(const std::array<unsigned char, N>& bits, int bit) {
  return (bits[static_cast<std::size_t>(bit) / 8] >> (bit % 8) & 1) != 0;
}

// SDL's GUID has the bus, vendor, product and version as 16-bit numbers, each with 16 bits of zeros behind it, in
// hexadecimal digits of the bytes from low to high.
unsigned NumberAt(const std::string& guid, std::size_t place) {
  if (guid.size() < place + 4) return 0;
  const auto byte = [&](std::size_t at) { return std::strtoul(guid.substr(at, 2).c_str(), nullptr, 16); };
  return static_cast<unsigned>(byte(place) + 256 * byte(place + 2));
}

bool Shakes(int file, const std::string& name, const std::string& guid) {
  std::array<unsigned char, (EV_MAX + 8) / 8> kinds{};
  std::array<unsigned char, (FF_MAX + 8) / 8> effects{};
  std::array<char, 256> its_name{};
  input_id id{};
  if (ioctl(file, EVIOCGBIT(0, kinds.size()), kinds.data()) < 0 || !HasBit(kinds, EV_FF)) return false;
  if (ioctl(file, EVIOCGBIT(EV_FF, effects.size()), effects.data()) < 0 || !HasBit(effects, FF_RUMBLE)) return false;
  if (ioctl(file, EVIOCGNAME(its_name.size() - 1), its_name.data()) < 0 || ioctl(file, EVIOCGID, &id) < 0) return false;
  return name == its_name.data() && id.vendor == NumberAt(guid, 8) && id.product == NumberAt(guid, 16);
}

int Open(const std::string& name, const std::string& guid) {
  DIR* folder = opendir(kFolder);
  if (folder == nullptr) return -1;
  int found = -1;
  while (found < 0) {
    const dirent* entry = readdir(folder);
    if (entry == nullptr) break;
    const std::string file_name = entry->d_name;
    if (file_name.rfind("event", 0) != 0) continue;
    const int file = open((std::string(kFolder) + "/" + file_name).c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (file < 0) continue;
    if (Shakes(file, name, guid)) {
      found = file;
    } else {
      close(file);
    }
  }
  closedir(folder);
  return found;
}

}  // namespace

Rumble::~Rumble() {
  Close();
}

// The kernel removes a file's effects when it is closed.
void Rumble::Close() {
  if (file_ >= 0) close(file_);
  file_ = -1;
  effect_ = -1;
  share_ = 0.0;
}

void Rumble::Choose(const std::string& name, const std::string& guid) {
  const std::string wanted = name + '\n' + guid;
  if (wanted == chosen_) return;
  chosen_ = wanted;
  Close();
  if (!guid.empty()) file_ = Open(name, guid);
}

void Rumble::Set(double share, double now_s) {
  if (file_ < 0) return;
  share = std::clamp(share, 0.0, 1.0);
  const bool is_new = std::abs(share - share_) > kStep || (share == 0.0) != (share_ == 0.0);
  const bool is_time = share > 0.0 && now_s - sent_s_ > kPeriod_s;
  if (!is_new && !is_time) return;
  ff_effect effect{};
  effect.type = FF_RUMBLE;
  effect.id = effect_;
  effect.replay.length = static_cast<__u16>(1e3 * kLength_s);
  effect.u.rumble.strong_magnitude = effect.u.rumble.weak_magnitude = static_cast<__u16>(std::lround(65535.0 * share));
  input_event play{};
  play.type = EV_FF;
  // An unplugged pad: GLFW notices, and another one is chosen then.
  if (ioctl(file_, EVIOCSFF, &effect) < 0) return Close();
  effect_ = effect.id;
  play.code = static_cast<__u16>(effect_);
  play.value = share > 0.0 ? 1 : 0;
  if (write(file_, &play, sizeof play) != static_cast<ssize_t>(sizeof play)) return Close();
  share_ = share;
  sent_s_ = now_s;
}

}  // namespace visual_node
