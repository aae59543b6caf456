#pragma once

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "config/daemon_config.hpp"
#include "daemon/counters.hpp"
#include "daemon/frame_joiner.hpp"
#include "daemon/handler_memory.hpp"
#include "daemon/rate_meter.hpp"
#include "daemon/sealed_port.hpp"
#include "daemon/session_recorder.hpp"
#include "daemon/source_pin.hpp"
#include "protocol/tracker_frame.hpp"

namespace tissued::daemon {

/// Takes tracker datagrams off their socket, decodes them and joins them to frames. Whenever the socket is readable all
/// that waits there is taken, and only the newest frame handed on; older ones are counted as skipped. Where there are
/// keys, what is not sealed with one is refused, but for what the configured peer sends; see SourcePin, too.
class TrackerReceiver {
 public:
  using OnFrame = std::function<void(const protocol::TrackerFrame&)>;

  /// Binds the socket; throws BindError. on_frame is called on the context's thread, from start() on.
  /// recorder: null, or what is told every datagram; outlives this.
  TrackerReceiver(boost::asio::io_context& context, const config::DaemonConfig& config, Counters& counters,
                  OnFrame on_frame, SessionRecorder* recorder = nullptr);

  void start();
  void close();
  /// Takes on staleness.
  void apply(const config::DaemonConfig& config);
  /// Believes these instead, where there were keys at the start.
  void use(std::span<const config::PreSharedKey> keys);
  std::uint16_t port() const { return port_; }
  /// Frames received in the last second, skipped ones too.
  double rate_hz(std::uint64_t now_ns) const { return rate_.rate_hz(now_ns); }

 private:
  void wait_readable();
  void drain();
  void take(std::span<const std::uint8_t> bytes, const boost::asio::ip::udp::endpoint& from, std::uint64_t receive_ns);
  std::optional<std::span<const std::uint8_t>> opened(std::span<const std::uint8_t> bytes,
                                                      const boost::asio::ip::udp::endpoint& from);
  void keep_newest(std::span<const protocol::TrackerFrame> frames);
  void hand_on();
  void watch_deadline();
  void shut_others_out(const boost::asio::ip::udp::endpoint& from);
  void watch_silence();

  boost::asio::ip::udp::socket socket_;
  boost::asio::steady_timer deadline_;
  boost::asio::steady_timer silence_;
  HandlerMemory silence_memory_;
  bool others_shut_out_ = false;
  std::uint16_t port_ = 0;
  Counters& counters_;
  OnFrame on_frame_;
  SessionRecorder* recorder_;
  std::unique_ptr<SealedPort> sealed_;  // null: there are no keys
  SourcePin pin_;
  FrameJoiner joiner_;
  RateMeter rate_;
  bool deadline_armed_ = false;
  std::uint64_t newest_receive_ns_ = 0;
  std::optional<protocol::TrackerFrame> newest_;                 // complete, not handed on yet
  std::array<std::uint8_t, protocol::kMaxSealed + 1> buffer_{};  // one more, to tell what is too long
};

}  // namespace tissued::daemon
