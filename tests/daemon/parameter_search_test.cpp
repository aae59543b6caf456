#include "daemon/parameter_search.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "daemon/ctl_options.hpp"
#include "daemon/evaluation_trace.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued::daemon;

namespace {

const std::vector<VariedKey> kKeys{{"a.x", -3.0, 5.0}, {"a.y", 10.0, 30.0}, {"b", 0.0, 1.0}};
const SearchPoint kMinimum{1.5, 22.0, 0.3};

// A bowl, steeper along x: its minimum and the value there are known.
double bowl(const SearchPoint& p) {
  return 7.0 + 4.0 * std::pow(p[0] - kMinimum[0], 2) + 0.02 * std::pow(p[1] - kMinimum[1], 2) +
         std::pow(p[2] - kMinimum[2], 2);
}

// The bowl at many points; remembers which were asked for.
struct Bowl {
  std::vector<SearchPoint> asked;
  std::vector<std::size_t> batches;
  std::vector<double> operator()(const std::vector<SearchPoint>& points) {
    std::vector<double> values;
    for (const SearchPoint& point : points) values.push_back(bowl(point));
    asked.insert(asked.end(), points.begin(), points.end());
    batches.push_back(points.size());
    return values;
  }
};

std::string text_of(const std::filesystem::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

void check_bounds(const std::vector<SearchPoint>& points, const std::vector<VariedKey>& keys) {
  for (const SearchPoint& point : points)
    for (std::size_t i = 0; i < keys.size(); ++i) {
      CHECK(point[i] >= keys[i].low);
      CHECK(point[i] <= keys[i].high);
    }
}

}  // namespace

TEST_CASE("The population closes in on a known minimum, a generation at a time, and keeps the bounds") {
  Bowl bowl_asked;
  const SearchResult found = search_globally(kKeys, std::ref(bowl_asked), {24, 40, 3});
  CHECK(found.value == bowl(found.point));
  CHECK(found.value < 7.1);
  CHECK(std::abs(found.point[0] - kMinimum[0]) < 0.2);
  REQUIRE(bowl_asked.batches.size() == 41);
  CHECK(bowl_asked.batches.front() == 24);
  for (const std::size_t batch : bowl_asked.batches) CHECK(batch <= 24);
  CHECK(std::set(bowl_asked.asked.begin(), bowl_asked.asked.end()).size() == bowl_asked.asked.size());
  check_bounds(bowl_asked.asked, kKeys);
  for (const SearchPoint& point : bowl_asked.asked) CHECK(bowl(point) >= found.value);
}

TEST_CASE("A seed decides which points a population asks for") {
  Bowl one, same, other;
  search_globally(kKeys, std::ref(one), {12, 5, 8});
  search_globally(kKeys, std::ref(same), {12, 5, 8});
  search_globally(kKeys, std::ref(other), {12, 5, 9});
  CHECK(one.asked == same.asked);
  CHECK(one.asked != other.asked);
}

TEST_CASE("Compass search ends at a known minimum and keeps the bounds") {
  Bowl bowl_asked;
  const SearchResult found = search_around(kKeys, {4.5, 12.0, 0.9}, std::ref(bowl_asked), 1000);
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(std::abs(found.point[i] - kMinimum[i]) < 2e-3 * (kKeys[i].high - kKeys[i].low));
  check_bounds(bowl_asked.asked, kKeys);

  const SearchResult cornered = search_around({{"x", 2.0, 5.0}, {"y", 10.0, 20.0}, {"z", 0.0, 1.0}}, {4.0, 12.0, 0.3},
                                              std::ref(bowl_asked), 1000);
  CHECK(cornered.point[0] == Approx(2.0).margin(0.01));
  CHECK(cornered.point[1] == Approx(20.0).margin(0.02));

  Bowl few;
  search_around(kKeys, {4.5, 12.0, 0.9}, std::ref(few), 10);
  CHECK(few.asked.size() >= 10);
  CHECK(few.asked.size() <= 10 + 2 * 3);
}

TEST_CASE("Narrowed bounds are a share of the width around the start, and no wider than before") {
  const std::vector<VariedKey> keys = narrowed(kKeys, {1.0, 29.0, 0.5}, 0.4);
  CHECK(keys[0].low == Approx(-0.6));
  CHECK(keys[0].high == Approx(2.6));
  CHECK(keys[1].low == Approx(25.0));
  CHECK(keys[1].high == 30.0);
  CHECK(keys[2].key == "b");
}

TEST_CASE("A search that was broken off goes on to the same result, to the bit, and asks nothing twice") {
  const bool fine = GENERATE(false, true);
  const TemporaryFolder folder;
  const auto search = [&](const std::string& file, int most, Bowl& asked) {
    EvaluationTrace trace(folder.path() / file, "bowl", kKeys);
    const SearchObjective limited = [&](const std::vector<SearchPoint>& points) {
      return trace.evaluate(points, [&](const std::vector<SearchPoint>& unknown) {
        if (static_cast<int>(asked.batches.size()) == most) throw std::runtime_error("killed");
        return asked(unknown);
      });
    };
    return fine ? search_around(kKeys, {4.5, 12.0, 0.9}, limited, 200) : search_globally(kKeys, limited, {16, 9, 4});
  };
  Bowl whole, first, second;
  const SearchResult uninterrupted = search("whole.csv", 1000, whole);
  CHECK_THROWS_WITH(search("broken.csv", 4, first), Catch::Contains("killed"));
  const SearchResult resumed = search("broken.csv", 1000, second);
  CHECK(resumed.point == uninterrupted.point);
  CHECK(resumed.value == uninterrupted.value);
  CHECK(first.asked.size() + second.asked.size() == whole.asked.size());
  CHECK(text_of(folder.path() / "broken.csv") == text_of(folder.path() / "whole.csv"));
}

TEST_CASE("A trace of another search, or one that is no trace, is refused") {
  const TemporaryFolder folder;
  const auto objective = [](const std::vector<SearchPoint>& points) { return std::vector<double>(points.size(), 2.0); };
  EvaluationTrace(folder.path() / "t.csv", "one", kKeys).evaluate({{0.1, 11.0, 1.0 / 3.0}}, objective);
  CHECK(EvaluationTrace(folder.path() / "t.csv", "one", kKeys).count() == 1);
  CHECK_THROWS_AS(EvaluationTrace(folder.path() / "t.csv", "two", kKeys), UsageError);
  const std::vector<VariedKey> fewer{kKeys[0], kKeys[1]};
  CHECK_THROWS_AS(EvaluationTrace(folder.path() / "t.csv", "one", fewer), UsageError);
  folder.write("t.csv", text_of(folder.path() / "t.csv") + "1,2,x,4\n");
  CHECK_THROWS_WITH(EvaluationTrace(folder.path() / "t.csv", "one", kKeys), Catch::Contains("`x`"));
}
