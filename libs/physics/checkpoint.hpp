#pragma once

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

namespace physics {

// State of a world as bytes, written and read by the same code, so that the two cannot differ. Meant for the program
// that wrote it: a restart goes on bit for bit, in a world that was built in the same way.
class Checkpoint {
 public:
  // Begins anew in either direction; what was written stays for reading.
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
