#include "tools/contact/methods/answer_table.hpp"

#include <unistd.h>

#include <cstdio>

namespace contact {

core::Result<AnswerTable> AnswerTable::Create(const std::filesystem::path& file) {
  AnswerTable table;
  std::error_code error;
  if (file.empty() || std::filesystem::is_directory(file, error)) {
    return core::Fail(core::ErrorCode::kIo, file.string() + ": cannot be written: not a file's name");
  }
  table.file_ = file;
  table.partial_ = file.string() + ".partial-" + std::to_string(getpid());
  table.stream_.open(table.partial_, std::ios::binary | std::ios::trunc);
  if (!table.stream_) {
    return core::Fail(core::ErrorCode::kIo, file.string() + ": cannot be written: is there such a folder, writable?");
  }
  table.stream_ << kHeading << '\n';
  return table;
}

AnswerTable::~AnswerTable() {
  if (!stream_.is_open()) return;
  stream_.close();
  std::error_code error;
  std::filesystem::remove(partial_, error);
}

void AnswerTable::Add(const Answer& a, double time_us) {
  char row[512];
  std::snprintf(row, sizeof(row), "%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%llu,%llu,%.3f,", a.signed_distance_m,
                a.force_A.x, a.force_A.y, a.force_A.z, a.moment_A.x, a.moment_A.y, a.moment_A.z,
                static_cast<unsigned long long>(a.contacts), static_cast<unsigned long long>(a.points_tested), time_us);
  stream_ << row;
  if (a.force_error) {
    std::snprintf(row, sizeof(row), "%.12g", *a.force_error);
    stream_ << row;
  }
  stream_ << '\n';
}

core::Result<void> AnswerTable::Commit() {
  stream_.close();
  std::error_code error;
  if (stream_) std::filesystem::rename(partial_, file_, error);
  if (!stream_ || error) {
    std::error_code ignored;
    std::filesystem::remove(partial_, ignored);
    return core::Fail(core::ErrorCode::kIo, file_.string() + ": cannot be written" +
                                                (error ? ": " + error.message() : std::string(": is the disk full?")));
  }
  return {};
}

}  // namespace contact
