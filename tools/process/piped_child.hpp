#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace process {

// A child process at the other end of pipes. In a process group of its own, so that a Ctrl-C at the terminal reaches
// only the launcher; ends when the launcher does.
class PipedChild {
 public:
  static core::Result<std::unique_ptr<PipedChild>> Start(const std::vector<std::string>& words);
  ~PipedChild();
  PipedChild(const PipedChild&) = delete;
  PipedChild& operator=(const PipedChild&) = delete;

  void Write(const std::string& text);
  void CloseInput();
  // Takes what has come on stdout and stderr, and the exit status when all has. Does not wait.
  void Poll();
  [[nodiscard]] bool has_ended() const { return status_.has_value(); }
  [[nodiscard]] int status() const { return status_.value_or(-1); }
  [[nodiscard]] const std::string& out() const { return out_; }
  [[nodiscard]] const std::string& err() const { return err_; }
  // Removes and returns the complete lines of stdout.
  std::vector<std::string> TakeLines();
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] int out_fd() const { return fds_[1]; }
  [[nodiscard]] int err_fd() const { return fds_[2]; }

 private:
  PipedChild() = default;
  void ReadFrom(int* fd, std::string* text);

  pid_t pid_ = -1;
  int fds_[3] = {-1, -1, -1};
  std::string unwritten_, out_, err_;
  bool closes_input_ = false;
  std::optional<int> status_;
};

// Waits until one of the children has something to say, at most `timeout_ms`.
void WaitForAny(const std::vector<PipedChild*>& children, int timeout_ms);

// What a child said, and its exit status.
struct Answer {
  int status = -1;
  std::string out, err;
  [[nodiscard]] bool is_good() const { return status == 0; }
  // Values of the lines "key=value" of stdout.
  [[nodiscard]] std::vector<std::string> values(const std::string& key) const;
  [[nodiscard]] std::string value(const std::string& key) const;  // the first; empty: none
};

// A command of this machine, with `input` on its stdin.
core::Result<Answer> RunHere(const std::vector<std::string>& words, const std::string& input = "",
                             double patience_s = 60.0);

// Polls until all have ended or the time is over.
void Finish(const std::vector<PipedChild*>& children, double patience_s);

// Status 124 when it has not ended.
Answer AnswerOf(const PipedChild& child);

}  // namespace process
