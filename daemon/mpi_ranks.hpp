#pragma once

#include <optional>
#include <string>

namespace tissued::daemon {

/// The processes that one mpirun started, and messages among them. Without MPI, or not started by mpirun: one alone.
/// All calls from the thread that made it; at most one in a process.
class MpiRanks {
 public:
  MpiRanks();
  ~MpiRanks();
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }
  /// This rank's share of its machine's processors, and of what mpirun bound it to; at least 1.
  int processors() const;

  struct Message {
    int from = 0;
    std::string text;
  };
  void send(int to, const std::string& text) const;
  /// From any rank; nothing where none has arrived.
  std::optional<Message> poll() const;

 private:
  int rank_ = 0, size_ = 1, on_this_machine_ = 1;
  bool is_mpi_ = false;
};

}  // namespace tissued::daemon
