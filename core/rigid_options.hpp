// Options of the simulator `rigid`.
#pragma once

namespace tissued::core {

struct RigidOptions {
  // `none`: the body stays where it was at rest. `markers`: it follows the seen markers as one rigid piece.
  enum class Follow { none, markers };
  Follow follow = Follow::none;
};

}  // namespace tissued::core
