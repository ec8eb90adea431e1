#include "core/write_file.hpp"

#include <unistd.h>

#include <atomic>
#include <fstream>
#include <string>
#include <system_error>

namespace core {

Result<void> WriteFile(const std::filesystem::path& file, std::string_view bytes) {
  static std::atomic<unsigned> num_writes{0};
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  std::filesystem::path partial = file;
  partial += "." + std::to_string(getpid()) + "." + std::to_string(num_writes.fetch_add(1)) + ".partial";
  std::ofstream out(partial, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  error.clear();
  if (out) std::filesystem::rename(partial, file, error);
  if (out && !error) return {};
  const std::string why = error ? ": " + error.message() : "";
  std::filesystem::remove(partial, error);
  return Fail(ErrorCode::kIo, "cannot write " + file.string() + why);
}

}  // namespace core
