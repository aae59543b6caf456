#pragma once

#include <array>
#include <functional>
#include <vector>

#include "config/daemon_config.hpp"
#include "core/scene.hpp"
#include "protocol/client_messages.hpp"

namespace tissued::daemon {

/// What a client asks first: who this daemon is, and what it calls the things that it numbers.
class Introduction {
 public:
  Introduction(const config::DaemonConfig& config, const core::Scene& scene);

  const protocol::HelloReply& hello() const { return hello_; }
  /// The names of a kind, in as many messages as they need; one, without names, where there are none.
  void for_each_part(protocol::NameKind kind, const std::function<void(const protocol::Names&)>& take) const;

 private:
  protocol::HelloReply hello_;
  std::array<std::vector<protocol::Name>, 5> names_;  // by protocol::NameKind
};

}  // namespace tissued::daemon
