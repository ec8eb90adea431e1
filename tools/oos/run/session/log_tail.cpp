#include "tools/oos/run/session/log_tail.hpp"

#include <fstream>
#include <iterator>

namespace oos {

std::string LogTail::NewestLine() {
  std::ifstream log(file_, std::ios::binary);
  log.seekg(read_bytes_);
  const std::string text{std::istreambuf_iterator<char>(log), {}};
  const std::size_t end = text.rfind('\n');
  if (end == std::string::npos) return {};
  read_bytes_ += static_cast<std::streamoff>(end + 1);
  const std::size_t before = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return text.substr(begin, end - begin);
}

}  // namespace oos
