#include "daemon/reload.hpp"

#include <boost/asio/post.hpp>
#include <csignal>
#include <exception>
#include <optional>
#include <utility>

#include "config/json_reader.hpp"
#include "daemon/realtime.hpp"

namespace tissued::daemon {

namespace {

bool is_taken_on(const std::string& pointer) { return pointer == "/log/level" || pointer.starts_with("/staleness"); }

template <typename Result>
struct Attempt {
  std::optional<Result> result;
  std::string fault;
};

template <typename Work>
auto attempt(const Work& work) -> Attempt<decltype(work())> {
  try {
    return {work(), {}};
  } catch (const std::exception& error) {
    return {std::nullopt, error.what()};
  }
}

}  // namespace

std::vector<std::string> changes_that_need_a_start(const config::DaemonConfig& running,
                                                   const config::DaemonConfig& wanted) {
  std::vector<std::string> changes;
  const auto flat = [](const config::DaemonConfig& config) { return config::Json::parse(config.document).flatten(); };
  const config::Json then = flat(running), now = flat(wanted);
  for (const auto& [pointer, value] : then.items()) {
    if (!is_taken_on(pointer) && (!now.contains(pointer) || now[pointer] != value)) changes.push_back(pointer);
  }
  for (const auto& [pointer, value] : now.items()) {
    if (!is_taken_on(pointer) && !then.contains(pointer)) changes.push_back(pointer);
  }
  // What the document leaves out, for it is of one run alone.
  const auto compare = [&changes](const char* pointer, const auto& a, const auto& b) {
    if (a != b) changes.emplace_back(pointer);
  };
  compare("/tracker/address", running.tracker.address, wanted.tracker.address);
  compare("/tracker/peer", running.tracker.peer, wanted.tracker.peer);
  compare("/tracker/peer_port", running.tracker.peer_port, wanted.tracker.peer_port);
  compare("/clients/address", running.clients.address, wanted.clients.address);
  compare("/clients/port", running.clients.port, wanted.clients.port);
  compare("/clients/max_subscribers", running.clients.max_subscribers, wanted.clients.max_subscribers);
  compare("/clients/prove_addresses", running.clients.prove_addresses, wanted.clients.prove_addresses);
  compare("/record", running.record, wanted.record);
  compare("/record_max_mb", running.record_max_bytes, wanted.record_max_bytes);
  compare("/keys", running.key_file, wanted.key_file);
  return changes;
}

Reload::Reload(boost::asio::io_context& context, Hooks hooks)
    : context_(context), hangup_(context, SIGHUP), hooks_(std::move(hooks)) {
  wait();
}

Reload::~Reload() {
  if (thread_.joinable()) thread_.join();
}

void Reload::wait() {
  hangup_.async_wait([this](const boost::system::error_code& error, int) {
    if (error) return;
    if (reading_) {
      again_ = true;
    } else {
      begin();
    }
    wait();
  });
}

void Reload::begin() {
  if (thread_.joinable()) thread_.join();  // it has posted its last already
  reading_ = true;
  thread_ = std::thread([this] {
    leave_realtime();
    auto keys = hooks_.load_keys ? attempt(hooks_.load_keys) : Attempt<Keys>{};
    auto config = attempt(hooks_.load);
    boost::asio::post(context_, [this, keys = std::move(keys), config = std::move(config)] {
      reading_ = false;
      if (keys.result) hooks_.use_keys(*keys.result);
      if (!keys.fault.empty()) hooks_.refuse("keys not read again, those so far are still believed: " + keys.fault);
      if (config.result) hooks_.apply(*config.result);
      if (!config.fault.empty()) hooks_.refuse("configuration not read again, the one so far stays: " + config.fault);
      if (std::exchange(again_, false)) begin();
    });
  });
}

}  // namespace tissued::daemon
