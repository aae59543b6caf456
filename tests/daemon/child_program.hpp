#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <vector>

// A program of ours as a child process, its stdout and stderr in pipes.
class ChildProgram {
 public:
  // The path is looked for in PATH where it has no slash. environment: `NAME=VALUE` beside what this process has.
  explicit ChildProgram(const std::string& path, const std::vector<std::string>& arguments,
                        const std::vector<std::string>& environment = {});
  // Kills it where it still runs.
  ~ChildProgram();
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;

  // The next line of stdout, without its end; empty when there is none before the timeout or the end of the program.
  std::string read_line(std::chrono::milliseconds timeout = std::chrono::seconds(20));
  void signal(int number) const;
  pid_t id() const { return child_; }
  // Its exit code; -1 where it did not end by itself in time.
  int wait(std::chrono::milliseconds timeout = std::chrono::seconds(20));

  // What remains in the pipes once it has ended.
  std::string rest_of_stdout();
  std::string rest_of_stderr();

 private:
  pid_t child_ = -1;
  int stdout_ = -1;
  int stderr_ = -1;
  bool ended_ = false;
};
