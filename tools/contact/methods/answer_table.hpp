#pragma once

#include <filesystem>
#include <fstream>

#include "core/result.hpp"
#include "tools/contact/methods/method.hpp"

namespace contact {

// Answers as CSV, a row for each pose; lengths in m, forces in m^3 or m, moments in m^4 or m^2 (Answer), time in us.
// Rows go to a temporary file beside `file`; Commit renames it, so that `file` is complete or not there at all.
class AnswerTable {
 public:
  // Errors: the file cannot be written.
  static core::Result<AnswerTable> Create(const std::filesystem::path& file);
  AnswerTable(AnswerTable&&) noexcept = default;
  AnswerTable& operator=(AnswerTable&&) = delete;
  ~AnswerTable();  // removes the temporary file

  void Add(const Answer& answer, double time_us);
  core::Result<void> Commit();

  static constexpr const char* kHeading =
      "signed_distance_m,fx,fy,fz,mx,my,mz,contacts,points_tested,time_us,force_error";

 private:
  AnswerTable() = default;

  std::filesystem::path file_;
  std::filesystem::path partial_;
  std::ofstream stream_;
};

}  // namespace contact
