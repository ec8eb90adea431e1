#pragma once

#include <filesystem>
#include <fstream>

#include "core/result.hpp"
#include "tools/contact/methods/method.hpp"

namespace contact {

// Answers as CSV. Rows go to a file beside the wanted one, which appears whole, by renaming, with Commit, or not at
// all.
class AnswerTable {
 public:
  static core::Result<AnswerTable> Create(const std::filesystem::path& file);
  AnswerTable(AnswerTable&&) noexcept = default;
  AnswerTable& operator=(AnswerTable&&) = delete;
  ~AnswerTable();

  void Add(const Answer& answer, double time_us);
  core::Result<void> Commit();

  static constexpr const char* kHeading = "signed_distance_m,fx,fy,fz,mx,my,mz,contacts,points_tested,time_us";

 private:
  AnswerTable() = default;

  std::filesystem::path file_;
  std::filesystem::path partial_;
  std::ofstream stream_;
};

}  // namespace contact
