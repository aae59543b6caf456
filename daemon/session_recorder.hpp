#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "config/bundle.hpp"
#include "daemon/answer.hpp"
#include "daemon/counters.hpp"
#include "daemon/record_ring.hpp"
#include "daemon/wake_up.hpp"
#include "protocol/session_file.hpp"
#include "protocol/tracker_frame.hpp"

namespace tissued::daemon {

/// FNV-1a over the bytes of the bundle's bundle.json, then of its mesh. Throws protocol::FileError.
std::uint64_t hash_of_bundle(const config::Bundle& bundle);

/// The n-th file of a recording, from 1: `live.rec`, `live.2.rec`, ...
std::filesystem::path part_of_recording(const std::filesystem::path& file, std::uint64_t n);

/// `file`, or where it or its second part exist the first of `live-2.rec`, `live-3.rec`, ... of which neither does.
std::filesystem::path free_recording(const std::filesystem::path& file);

/// Writes what the daemon receives and answers to a file, and when that has grown to the next, on a thread of its own.
/// The threads that hand records over never wait for it: what finds no room is counted and said in the file. What was
/// handed over is in the kernel's hands within kFlush, so that killing the daemon loses no more. Where the file cannot
/// be written any more (the disk is full) recording ends, the rest is counted as lost, and the callback is told once; a
/// record that was begun is taken back or left torn, which its reader recognises.
class SessionRecorder {
 public:
  static constexpr std::uint64_t kFlush_ns = 50'000'000;

  /// Creates the file, which must not exist yet, and writes its header and the configuration, JSON, from which the run
  /// can be repeated. max_bytes: of a file, as near as whole records allow. on_failure: one line, called on the
  /// recorder's thread. Throws std::system_error.
  SessionRecorder(const std::filesystem::path& file, std::uint64_t max_bytes, const protocol::SessionHeader& header,
                  const std::string& configuration, Counters& counters,
                  std::function<void(const std::string&)> on_failure);
  ~SessionRecorder() { stop(); }
  SessionRecorder(const SessionRecorder&) = delete;
  SessionRecorder& operator=(const SessionRecorder&) = delete;

  /// I/O thread.
  void add_tracker(std::uint64_t receive_ns, std::span<const std::uint8_t> bytes) noexcept;
  void add_client(std::uint64_t receive_ns, std::span<const std::uint8_t> bytes) noexcept;
  /// A frame was handed on because its time was up.
  void add_deadline(std::uint64_t now_ns) noexcept;
  /// Simulation thread. stepped: the frame that the answer was made of.
  void add_answer(const protocol::TrackerFrame& stepped, const Answer& answer) noexcept;

  /// Writes what is left, the state in which the simulation ended where it is told, and closes. Once the other threads
  /// add nothing any more.
  void stop(std::optional<std::uint64_t> state_hash = {});

 private:
  // One producer's.
  struct Source {
    explicit Source(std::size_t capacity) : ring(capacity) {}
    RecordRing ring;
    std::atomic<std::uint64_t> lost{0};
    std::uint64_t lost_said = 0;  // the recorder's own
  };

  void add(Source& source, protocol::SessionRecordKind kind, std::uint64_t stamp_ns,
           std::span<const std::uint8_t> body) noexcept;
  void run() noexcept;
  int open_part();
  void go_on_in_next_part() noexcept;
  void drain(Source& source) noexcept;
  void say_losses(Source& source) noexcept;
  void append_number(protocol::SessionRecordKind kind, std::uint64_t number) noexcept;
  void append(const protocol::SessionRecord& record) noexcept;
  void flush() noexcept;
  void write_pending() noexcept;
  void fail(int error) noexcept;

  std::filesystem::path first_;
  std::string name_;  // of the file at hand
  std::uint64_t max_bytes_;
  protocol::SessionHeader header_;
  std::string configuration_;
  std::uint64_t part_ = 1;
  Counters& counters_;
  std::function<void(const std::string&)> on_failure_;
  int file_ = -1;
  Source datagrams_, answers_;
  std::vector<std::uint8_t> pending_;  // to be written, in whole records
  std::size_t pending_size_ = 0, pending_records_ = 0;
  std::vector<std::uint8_t> body_;
  std::uint64_t written_ = 0;  // bytes, in the file
  bool failed_ = false;
  std::atomic<bool> stopping_{false};
  std::optional<std::uint64_t> state_hash_;  // before stopping_
  bool empty_ = true;                        // nothing was added
  std::thread thread_;
};

}  // namespace tissued::daemon
