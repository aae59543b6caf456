#include "daemon/overlay_writer.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "daemon/image_overlay.hpp"
#include "daemon/monotonic_clock.hpp"
#include "daemon/subscription.hpp"

namespace tissued::daemon {
namespace {

constexpr std::uint64_t kPatience_ns = 2'000'000'000;

std::size_t index_of(const std::vector<std::string>& probes, const std::string& name) {
  if (probes.empty()) throw std::runtime_error("the daemon's scene has no probe");
  if (name.empty()) return 0;
  const auto found = std::find(probes.begin(), probes.end(), name);
  if (found == probes.end()) throw std::runtime_error("the daemon's scene has no probe `" + name + "`");
  return static_cast<std::size_t>(found - probes.begin());
}

JoinedView next_view(PredictionClient& client, Subscription& subscription, std::size_t probe) {
  const std::uint64_t deadline = monotonic_ns() + kPatience_ns;
  ViewJoiner joiner;
  while (const auto message = subscription.receive(deadline)) {
    const auto* part = std::get_if<protocol::ProbeView>(&message->message);
    if (part == nullptr) continue;
    const auto views = joiner.add(*part);
    if (views && probe < views->size()) return (*views)[probe];
  }
  throw NoAnswer("no view of the probe from " + to_string(client.daemon()) + ": is tissued running there?");
}

}  // namespace

void write_overlays(PredictionClient& client, const OverlayRequest& request) {
  const std::vector<std::string> targets = client.names(protocol::NameKind::target);
  const std::size_t probe = index_of(client.names(protocol::NameKind::probe), request.probe);
  std::filesystem::create_directories(request.folder);
  Subscription subscription(client, protocol::kProbes, 0.0);
  for (const std::filesystem::path& file : request.images) {
    const std::filesystem::path out = request.folder / file.filename();
    std::error_code ignored;
    if (std::filesystem::equivalent(file, out, ignored))
      throw std::runtime_error(out.string() + ": is the image itself; --out must be another folder");
    RgbImage image = read_png(file);
    const JoinedView view = next_view(client, subscription, probe);
    try {
      draw_overlay(view, targets, image);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(file.string() + ": " + error.what());
    }
    write_png(image, out);
    std::printf("%s: frame %u, %s\n", out.c_str(), view.frame.tracker_frame, protocol::to_string(view.frame.validity));
  }
}

}  // namespace tissued::daemon
