#include "daemon/session_recorder.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <string_view>
#include <system_error>
#include <utility>

#include "daemon/answer_messages.hpp"
#include "daemon/monotonic_clock.hpp"
#include "protocol/bytes.hpp"
#include "protocol/file_content.hpp"

namespace tissued::daemon {

namespace {

using protocol::SessionRecordKind;

constexpr std::size_t kDatagramRing = std::size_t{4} << 20, kAnswerRing = std::size_t{1} << 20;  // bytes
constexpr std::size_t kPending = std::size_t{1} << 18;                                           // bytes
constexpr std::chrono::milliseconds kGlance{10};

std::uint64_t fnv1a(std::string_view text, std::uint64_t value) {
  for (const char c : text) value = (value ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return value;
}

}  // namespace

std::uint64_t hash_of_bundle(const config::Bundle& bundle) {
  std::uint64_t value = 14695981039346656037ull;
  for (const auto& file : {bundle.folder / "bundle.json", bundle.mesh_file})
    value = fnv1a(protocol::read_file_content(file), value);
  return value;
}

std::filesystem::path part_of_recording(const std::filesystem::path& file, std::uint64_t n) {
  if (n == 1) return file;
  std::string name = file.stem().string();
  name.append(".").append(std::to_string(n)).append(file.extension().string());
  return file.parent_path() / name;
}

std::filesystem::path free_recording(const std::filesystem::path& file) {
  std::filesystem::path free = file;
  for (int n = 2; std::filesystem::exists(free) || std::filesystem::exists(part_of_recording(free, 2)); ++n) {
    std::string name = file.stem().string();
    name.append("-").append(std::to_string(n)).append(file.extension().string());
    free = file.parent_path() / name;
  }
  return free;
}

SessionRecorder::SessionRecorder(const std::filesystem::path& file, std::uint64_t max_bytes,
                                 const protocol::SessionHeader& header, const std::string& configuration,
                                 Counters& counters, std::function<void(const std::string&)> on_failure)
    : first_(file),
      max_bytes_(max_bytes),
      header_(header),
      configuration_(configuration),
      counters_(counters),
      on_failure_(std::move(on_failure)),
      datagrams_(kDatagramRing),
      answers_(kAnswerRing),
      pending_(kPending),
      body_(protocol::kMaxSessionBody) {
  // A file size limit is a full disk to us, not the end of the daemon.
  std::signal(SIGXFSZ, SIG_IGN);
  if (const int error = open_part(); error != 0)
    throw std::system_error(error, std::generic_category(), name_ + ": cannot be created");
  if (failed_) {
    ::close(file_);
    throw std::system_error(ENOSPC, std::generic_category(), name_ + ": cannot be written");
  }
  thread_ = std::thread([this] { run(); });
  ::pthread_setname_np(thread_.native_handle(), "recorder");
}

// Creates the file of part_ and writes its beginning, for a part without one is none; returns errno where it cannot be
// created. Nothing may be pending.
int SessionRecorder::open_part() {
  name_ = part_of_recording(first_, part_).string();
  file_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (file_ < 0) return errno;
  written_ = 0;
  pending_size_ = protocol::write_session_header(header_, pending_);
  // Also a text that fills its last piece has a shorter one behind it.
  const auto* text = reinterpret_cast<const std::uint8_t*>(configuration_.data());
  for (std::size_t begin = 0; begin <= configuration_.size(); begin += protocol::kMaxSessionBody) {
    const std::size_t size = std::min(protocol::kMaxSessionBody, configuration_.size() - begin);
    append({SessionRecordKind::configuration, header_.monotonic_ns, {text + begin, size}});
  }
  if (part_ > 1) append_number(SessionRecordKind::part, part_);
  write_pending();
  if (failed_) ::unlink(name_.c_str());
  return 0;
}

void SessionRecorder::go_on_in_next_part() noexcept {
  const int full = std::exchange(file_, -1);
  ++part_;
  try {
    if (const int error = open_part(); error != 0) fail(error);
  } catch (const std::exception&) {
    fail(ENOMEM);
  }
  ::close(full);
}

void SessionRecorder::stop(std::optional<std::uint64_t> state_hash) {
  if (!thread_.joinable()) return;
  state_hash_ = state_hash;
  stopping_.store(true, std::memory_order_release);
  thread_.join();
  if (file_ >= 0) ::close(file_);
  // Nothing came: where the daemon could not even start, the next start must find the name free.
  if (empty_) ::unlink(first_.c_str());
}

void SessionRecorder::add_tracker(std::uint64_t receive_ns, std::span<const std::uint8_t> bytes) noexcept {
  add(datagrams_, SessionRecordKind::tracker_datagram, receive_ns, bytes);
}

void SessionRecorder::add_client(std::uint64_t receive_ns, std::span<const std::uint8_t> bytes) noexcept {
  add(datagrams_, SessionRecordKind::client_datagram, receive_ns, bytes);
}

void SessionRecorder::add_deadline(std::uint64_t now_ns) noexcept {
  add(datagrams_, SessionRecordKind::deadline, now_ns, {});
}

void SessionRecorder::add_answer(const protocol::TrackerFrame& stepped, const Answer& answer) noexcept {
  const protocol::AnswerSummary summary = answer_summary(stepped.frame_number, answer);
  std::array<std::uint8_t, protocol::kMaxSessionBody> body;
  const std::size_t size = protocol::write_answer_summary(summary, body);
  if (size > 0) add(answers_, SessionRecordKind::answer, stepped.receive_ns, std::span(body).first(size));
}

void SessionRecorder::add(Source& source, SessionRecordKind kind, std::uint64_t stamp_ns,
                          std::span<const std::uint8_t> body) noexcept {
  if (source.ring.push(static_cast<std::uint8_t>(kind), stamp_ns, body)) return;
  source.lost.fetch_add(1, std::memory_order_relaxed);
  counters_.add(Count::records_lost);
}

void SessionRecorder::run() noexcept {
  for (;;) {
    const bool last = stopping_.load(std::memory_order_acquire);
    drain(datagrams_);
    drain(answers_);
    if (last && state_hash_ && !empty_) append_number(SessionRecordKind::end, *state_hash_);
    flush();
    if (last) return;
    std::this_thread::sleep_for(kGlance);
  }
}

void SessionRecorder::drain(Source& source) noexcept {
  RecordRing::Entry entry;
  while (source.ring.pop(entry, body_)) {
    empty_ = false;
    append({static_cast<SessionRecordKind>(entry.kind), entry.stamp_ns, std::span(body_).first(entry.size)});
  }
  say_losses(source);
}

void SessionRecorder::say_losses(Source& source) noexcept {
  const std::uint64_t lost = source.lost.load(std::memory_order_relaxed);
  if (lost == source.lost_said) return;
  append_number(SessionRecordKind::lost, lost - source.lost_said);
  source.lost_said = lost;
}

void SessionRecorder::append_number(SessionRecordKind kind, std::uint64_t number) noexcept {
  std::array<std::uint8_t, 8> body;
  protocol::ByteWriter(body).u64(number);
  append({kind, monotonic_ns(), body});
}

void SessionRecorder::append(const protocol::SessionRecord& record) noexcept {
  if (failed_) {
    counters_.add(Count::records_lost);
    return;
  }
  if (pending_size_ + protocol::kSessionRecordOverhead + record.body.size() > pending_.size()) flush();
  const std::size_t size = protocol::write_session_record(record, std::span(pending_).subspan(pending_size_));
  pending_size_ += size;
  ++pending_records_;
}

void SessionRecorder::flush() noexcept {
  write_pending();
  if (!failed_ && written_ >= max_bytes_) go_on_in_next_part();
}

void SessionRecorder::write_pending() noexcept {
  std::size_t done = 0;
  while (!failed_ && done < pending_size_) {
    const ssize_t size = ::write(file_, pending_.data() + done, pending_size_ - done);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      fail(size < 0 ? errno : ENOSPC);
      break;
    }
    done += static_cast<std::size_t>(size);
  }
  if (failed_) {
    if (pending_records_ > 0) counters_.add(Count::records_lost, pending_records_);
  } else {
    written_ += pending_size_;
    counters_.add(Count::records_written, pending_records_);
  }
  pending_size_ = pending_records_ = 0;
}

void SessionRecorder::fail(int error) noexcept {
  failed_ = true;
  counters_.set(Count::recording_failed, 1);
  // What is in the file up to here is whole; where it cannot be cut, its reader recognises the torn tail.
  if (file_ >= 0) [[maybe_unused]]
    const int refused = ::ftruncate(file_, static_cast<off_t>(written_));
  if (on_failure_) on_failure_(name_ + ": recording ended: " + std::strerror(error));
}

}  // namespace tissued::daemon
