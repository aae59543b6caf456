// What a study of nulls says of the thresholds of diagnosis.cpp.
#pragma once

#include <iosfwd>
#include <vector>

#include "tests/study/null_row.hpp"

namespace tissued::study {

// Of a share that was seen as `count` of `all`: 95 % interval of Clopper and Pearson.
struct Interval {
  double low = 0.0, high = 1.0;
};
Interval clopper_pearson(int count, int all);

// Physics, a fault of measurement, or `unexplained`.
bool is_false_alarm(const NullRow& row);

void summarise(const std::vector<NullRow>& rows, std::ostream& out);

}  // namespace tissued::study
