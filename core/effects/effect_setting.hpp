#pragma once

#include <vector>

namespace tissued::core {

class Effect;

// An effect with all of its numbers.
struct EffectSetting {
  const Effect* effect = nullptr;
  std::vector<double> values;  // beside effect->parameters()
};

}  // namespace tissued::core
