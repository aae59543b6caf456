#include "daemon/overload_rule.hpp"

#include <catch2/catch.hpp>
#include <vector>

using tissued::daemon::OverloadRule;

namespace {

constexpr double kFrame = 0.01;  // s

void run(OverloadRule& rule, double seconds, double busy) {
  for (int i = 0; i < static_cast<int>(seconds / kFrame + 0.5); ++i) rule.note(busy * kFrame, kFrame);
}

}  // namespace

TEST_CASE("Nothing is left out while steps have room, nor for a single slow one") {
  OverloadRule rule(10);
  run(rule, 10.0, 0.85);
  rule.note(0.02, kFrame);
  run(rule, 10.0, 0.5);
  CHECK(rule.level() == 0);
  CHECK(rule.max_iterations() == 0);
  CHECK(OverloadRule::mesh_divisor(rule.level()) == 1);
}

TEST_CASE("Iterations are left out first, then meshes, a level for each quarter of a second") {
  OverloadRule rule(10);
  std::vector<int> iterations;
  std::vector<unsigned> divisors;
  for (int window = 0; window < 8; ++window) {
    run(rule, 0.25, 1.5);
    iterations.push_back(rule.max_iterations());
    divisors.push_back(OverloadRule::mesh_divisor(rule.level()));
  }
  CHECK(iterations == std::vector<int>{7, 5, 3, 3, 3, 3, 3, 3});
  CHECK(divisors == std::vector<unsigned>{1, 1, 1, 2, 4, 8, 8, 8});
}

TEST_CASE("There is always an iteration") {
  OverloadRule rule(1);
  run(rule, 1.0, 2.0);
  CHECK(rule.max_iterations() == 1);
}

TEST_CASE("A level is left after five calm seconds, where what comes back has room") {
  OverloadRule rule(10);
  run(rule, 0.25, 1.0);
  REQUIRE(rule.level() == 1);
  run(rule, 60.0, 0.6);  // with 10 iterations in place of 7: 0.86
  CHECK(rule.level() == 1);
  run(rule, 4.5, 0.4);
  CHECK(rule.level() == 1);
  run(rule, 1.0, 0.4);
  CHECK(rule.level() == 0);
}

TEST_CASE("Calm seconds count in one piece") {
  OverloadRule rule(10);
  run(rule, 0.25, 1.0);
  for (int i = 0; i < 10; ++i) {
    run(rule, 4.0, 0.3);
    run(rule, 0.5, 0.8);
  }
  CHECK(rule.level() == 1);
}
