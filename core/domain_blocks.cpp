#include "core/domain_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tissued::core {

namespace {

void fill_lane(const StrainDomain& domain, double weight_scale, bool repeated, int lane, DomainBlock& block,
               DomainCorner* corners) {
  block.volume[lane] = repeated ? 0.0 : domain.volume;
  block.shear_modulus[lane] = domain.shear_modulus;
  block.bulk_modulus[lane] = domain.bulk_modulus;
  block.stiffness[lane] = weight_scale * domain.stiffness;
  block.length[lane] = std::cbrt(6.0 * domain.volume);
  for (std::size_t a = 0; a < static_cast<std::size_t>(block.corner_count); ++a) {
    const bool present = a < domain.nodes.size();
    corners[a].row[lane] = 4 * static_cast<std::int64_t>(domain.nodes[present ? a : 0]);
    for (int axis = 0; axis < 3; ++axis) corners[a].gradient[axis][lane] = present ? domain.gradients[a][axis] : 0.0;
  }
}

}  // namespace

DomainBlocks make_domain_blocks(const std::vector<StrainDomain>& domains, double weight_scale) {
  std::vector<int> order(domains.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return domains[a].nodes.size() < domains[b].nodes.size(); });
  DomainBlocks out;
  const std::size_t blocks = (domains.size() + kLanes - 1) / kLanes;
  out.blocks.resize(blocks);
  for (std::size_t b = 0; b < blocks; ++b) {
    DomainBlock& block = out.blocks[b];
    const std::size_t last = std::min(b * kLanes + kLanes, domains.size()) - 1;
    block.first_corner = static_cast<std::int64_t>(out.corners.size());
    block.corner_count = static_cast<std::int64_t>(domains[order[last]].nodes.size());
    out.corners.resize(out.corners.size() + static_cast<std::size_t>(block.corner_count));
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const bool repeated = b * kLanes + lane > last;
      const int domain = order[std::min(b * kLanes + lane, last)];
      fill_lane(domains[domain], weight_scale, repeated, static_cast<int>(lane), block,
                &out.corners[static_cast<std::size_t>(block.first_corner)]);
      out.domain.push_back(repeated ? -1 : domain);
    }
  }
  return out;
}

void reset_domain_states(std::vector<DomainState>& states) {
  for (DomainState& state : states) {
    state = DomainState{};
    for (int lane = 0; lane < kLanes; ++lane) {
      state.factor[lane] = 1.0;
      for (int i = 0; i < 3; ++i) {
        state.v[4 * i][lane] = 1.0;
        state.stretch[i][lane] = 1.0;
      }
    }
  }
}

}  // namespace tissued::core
