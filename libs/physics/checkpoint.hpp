#pragma once

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

namespace physics {

// The state of a world as bytes. The same code writes and reads it, so the two cannot differ. A world that is built in
// the same way by the same program continues from it bit for bit.
class Checkpoint {
 public:
  // Start again at the first byte, for writing or for reading what was written.
  void BeginWriting() {
    bytes_.clear();
    is_writing_ = true;
  }
  void BeginReading() {
    at_ = 0;
    is_writing_ = false;
  }
  [[nodiscard]] bool is_reading() const { return !is_writing_; }
  template <typename T>
  void Exchange(T* value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (is_writing_) {
      bytes_.resize(bytes_.size() + sizeof(T));
      std::memcpy(&bytes_[bytes_.size() - sizeof(T)], value, sizeof(T));
    } else if (at_ + sizeof(T) <= bytes_.size()) {
      std::memcpy(value, &bytes_[at_], sizeof(T));
      at_ += sizeof(T);
    }
  }
  [[nodiscard]] const std::vector<std::byte>& bytes() const { return bytes_; }
  [[nodiscard]] std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
  bool is_writing_ = true;
};

}  // namespace physics
