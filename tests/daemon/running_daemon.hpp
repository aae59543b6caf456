#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include "daemon/runtime.hpp"
#include "tests/daemon/fake_simulator.hpp"

// The daemon's runtime on loopback and free ports around a fake simulator.
struct RunningDaemon {
  FakeSimulator simulator;
  tissued::daemon::Runtime runtime;
  std::thread thread;

  explicit RunningDaemon(const tissued::config::DaemonConfig& config = small_config(),
                         tissued::core::Scene scene = small_scene())
      : simulator(std::move(scene)), runtime(config, simulator), thread([this] { runtime.run(); }) {}
  ~RunningDaemon() { stop(); }

  void stop() {
    if (!thread.joinable()) return;
    runtime.stop();
    thread.join();
  }
  std::uint64_t count(auto what) const { return runtime.counters()[what]; }
};

// Waits until `holds`, for so long at most; returns whether it came true.
inline bool eventually(const std::function<bool()>& holds,
                       std::chrono::milliseconds timeout = std::chrono::seconds(5)) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}
