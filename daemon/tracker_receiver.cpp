#include "daemon/tracker_receiver.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "daemon/bound_socket.hpp"
#include "daemon/monotonic_clock.hpp"
#include "daemon/source_filter.hpp"
#include "daemon/stamped_receive.hpp"

namespace tissued::daemon {

namespace {

using boost::asio::ip::udp;

// So many datagrams at most before clients have their turn again: a flood must not silence the daemon.
constexpr int kMaxDrain = 1024;

}  // namespace

TrackerReceiver::TrackerReceiver(boost::asio::io_context& context, const config::DaemonConfig& config,
                                 Counters& counters, OnFrame on_frame, SessionRecorder* recorder)
    : socket_(bind_udp(context, "tracker", config.tracker.address, config.tracker.port)),
      deadline_(context),
      silence_(context),
      port_(socket_.local_endpoint().port()),
      counters_(counters),
      on_frame_(std::move(on_frame)),
      recorder_(recorder),
      sealed_(SealedPort::make(socket_, protocol::SealChannel::tracker, config.keys, counters)),
      pin_(config.tracker, config.staleness),
      joiner_(config) {
  stamp_arrivals(socket_.native_handle());
}

void TrackerReceiver::start() { wait_readable(); }

void TrackerReceiver::apply(const config::DaemonConfig& config) { pin_.apply(config.staleness); }

void TrackerReceiver::use(std::span<const config::PreSharedKey> keys) {
  if (sealed_) sealed_->use(keys);
}

void TrackerReceiver::close() {
  boost::system::error_code ignored;
  socket_.close(ignored);
}

void TrackerReceiver::wait_readable() {
  socket_.async_wait(udp::socket::wait_read, [this](const boost::system::error_code& error) {
    if (error) return;
    drain();
    wait_readable();
  });
}

void TrackerReceiver::drain() {
  for (int i = 0; i < kMaxDrain; ++i) {
    const auto received = receive_stamped(socket_.native_handle(), buffer_);
    if (!received) break;
    counters_.add(Count::tracker_datagrams);
    if (received->drops) counters_.set(Count::kernel_drops, *received->drops);
    // Stamps come by way of the wall clock; the assembler relies on a clock that does not go back.
    newest_receive_ns_ = std::max(newest_receive_ns_, received->receive_ns);
    take(std::span<const std::uint8_t>(buffer_).first(received->size), received->from, newest_receive_ns_);
  }
  hand_on();
}

// What the sender says, where he is one to be believed.
std::optional<std::span<const std::uint8_t>> TrackerReceiver::opened(std::span<const std::uint8_t> bytes,
                                                                     const udp::endpoint& from) {
  if (sealed_ && !(pin_.names_peer() && pin_.is_peer(from))) {
    const auto opened = sealed_->open(bytes, from);
    return opened ? std::optional(opened->payload) : std::nullopt;
  }
  if (pin_.is_peer(from)) return bytes;
  counters_.add(Count::foreign_datagrams);
  return std::nullopt;
}

void TrackerReceiver::take(std::span<const std::uint8_t> bytes, const udp::endpoint& from, std::uint64_t receive_ns) {
  const auto datagram = opened(bytes, from);
  if (!datagram) return;
  if (!pin_.continues(from, receive_ns)) return counters_.add(Count::foreign_datagrams);
  if (recorder_ != nullptr) recorder_->add_tracker(receive_ns, *datagram);
  keep_newest(joiner_.add(*datagram, receive_ns));
  counters_.add(joiner_.refusal());
  if (joiner_.refusal() == protocol::TrackerRefusal::none && (pin_.note(from, receive_ns) || !others_shut_out_))
    shut_others_out(from);
  if (const int skipped = joiner_.skipped_items(); skipped > 0)
    counters_.add(Count::unknown_items, static_cast<std::uint64_t>(skipped));
}

// A flood from elsewhere must not take the stream's room in the socket; until it is silent, and another may begin.
void TrackerReceiver::shut_others_out(const udp::endpoint& from) {
  admit_only(socket_.native_handle(), from);  // where the kernel does not, pin_ does
  others_shut_out_ = true;
  watch_silence();
}

void TrackerReceiver::watch_silence() {
  silence_.expires_at(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(pin_.free_ns())));
  silence_.async_wait(remembered(silence_memory_, [this](const boost::system::error_code& error) {
    if (error) return;
    if (monotonic_ns() < pin_.free_ns()) return watch_silence();
    admit_all(socket_.native_handle());
    others_shut_out_ = false;
  }));
}

void TrackerReceiver::keep_newest(std::span<const protocol::TrackerFrame> frames) {
  for (const auto& frame : frames) {
    rate_.note(frame.receive_ns);
    if (newest_) counters_.add(Count::frames_skipped);
    newest_ = frame;
  }
}

void TrackerReceiver::hand_on() {
  for (std::size_t i = 0; i < protocol::kAssemblerEventCount; ++i) {
    const auto event = static_cast<protocol::AssemblerEvent>(i);
    counters_.set(event, joiner_.count(event));
  }
  if (newest_) {
    on_frame_(*newest_);
    newest_.reset();
  }
  watch_deadline();
}

// A frame whose last datagram does not come is handed on when its time is up. The timer is left to run when the frame
// is completed before: re-arming it for every frame would cost more than a wake-up that finds nothing.
void TrackerReceiver::watch_deadline() {
  const auto due_ns = joiner_.due_ns();
  if (!due_ns || deadline_armed_) return;
  deadline_armed_ = true;
  deadline_.expires_at(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(*due_ns)));
  deadline_.async_wait([this](const boost::system::error_code& error) {
    deadline_armed_ = false;
    if (error) return;
    drain();  // what came in the meantime may be what is missing
    const std::uint64_t now_ns = monotonic_ns();
    const auto frames = joiner_.flush_if_due(now_ns);
    if (recorder_ != nullptr && !frames.empty()) recorder_->add_deadline(now_ns);
    keep_newest(frames);
    hand_on();
  });
}

}  // namespace tissued::daemon
