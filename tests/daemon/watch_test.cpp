#include <catch2/catch.hpp>
#include <cmath>

#include "daemon/text_table.hpp"
#include "daemon/watch_page.hpp"
#include "daemon/watch_report.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

constexpr std::uint64_t kSecond = 1'000'000'000;

protocol::Name name(const char* text) { return *protocol::Name::from(text); }

protocol::HelloReply sample_hello() {
  protocol::HelloReply hello;
  hello.version = name("1.2.3");
  hello.model = name("phantom");
  hello.simulator = name("kf-admm");
  return hello;
}

// Frame `number` of a tracker at 100 Hz; every target is `error` mm off in x, with 0.1 mm of standard deviation.
TargetAnswer answer_to(std::uint32_t number, double error, std::size_t targets = 2) {
  TargetAnswer answer;
  answer.frame.validity = protocol::Validity::valid;
  answer.frame.tracker_frame = number;
  answer.frame.receive_ns = kSecond + number * 10'000'000ull;
  answer.frame.send_ns = answer.frame.receive_ns + 2'000'000;
  answer.frame.age_ns = 2'000'000;
  answer.frame.step_time_ns = 1'500'000;
  answer.frame.markers_used = 18;
  answer.frame.markers_seen = 19;
  answer.receive_ns = answer.frame.send_ns + 50'000;
  for (std::size_t i = 0; i < targets; ++i) {
    protocol::TargetPrediction target;
    target.index = std::uint16_t(i);
    target.position = {error, 0, 30};
    target.covariance = {0.01, 0, 0, 0.01, 0, 0.01};
    target.has_truth = true;
    target.truth = {0, 0, 30};
    answer.targets.push_back(target);
  }
  return answer;
}

WatchStatistics after_frames(const std::vector<std::uint32_t>& numbers, double error = 0.2) {
  WatchStatistics statistics;
  statistics.introduce(sample_hello(), {"T1", "T2"}, {"A1"});
  for (const std::uint32_t number : numbers) statistics.add_streamed(answer_to(number, error));
  return statistics;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

const Connection kConnected{"127.0.0.1:51010", true, 0.0};

}  // namespace

TEST_CASE("Frames without an answer are counted by their numbers") {
  CHECK(after_frames({1, 2, 3}).lost() == 0);
  CHECK(after_frames({1, 2, 5, 6, 9}).lost() == 4);
  CHECK(after_frames({0xFFFFFFFE, 0xFFFFFFFF, 0, 1}).lost() == 0);  // the counter came round
  const WatchStatistics restarted = after_frames({500, 501, 1, 2});
  CHECK(restarted.lost() == 0);
  CHECK(restarted.restarts() == 1);
  CHECK(restarted.frames() == 4);
}

TEST_CASE("The same answer twice is one frame, a question's answer is none") {
  WatchStatistics statistics = after_frames({1, 2, 2, 2});
  CHECK(statistics.frames() == 2);
  statistics.add_asked(answer_to(9, 0.2));
  CHECK(statistics.frames() == 2);
  CHECK(statistics.lost() == 0);
  CHECK(statistics.latest()->frame.tracker_frame == 9);
}

TEST_CASE("Errors and their claims are accounted for") {
  WatchStatistics statistics;
  statistics.introduce(sample_hello(), {"T1"}, {});
  // The ellipsoid reaches sqrt(7.815) * 0.1 = 0.28 mm.
  for (std::uint32_t i = 1; i <= 10; ++i) statistics.add_streamed(answer_to(i, i <= 9 ? 0.2 : 0.3, 1));
  const ErrorStatistics& errors = statistics.targets()[0].errors;
  CHECK(errors.frames == 10);
  CHECK(errors.mean() == Approx(0.21));
  CHECK(errors.most == Approx(0.3));
  CHECK(errors.inside == 9);
  CHECK(errors.judged == 10);
}

TEST_CASE("Rate, latency and age follow the clock") {
  std::vector<std::uint32_t> numbers(150);
  for (std::uint32_t i = 0; i < 150; ++i) numbers[i] = i + 1;
  WatchStatistics statistics = after_frames(numbers);
  const std::uint64_t now = statistics.latest()->receive_ns + 5'000'000;
  statistics.tick(now);
  CHECK(statistics.rate_hz(now) == Approx(100.0));
  CHECK(statistics.age_ns(now) == 7'000'000);
  CHECK(statistics.latency().percentile_ms(0.99) == Approx(2.0));
  CHECK(statistics.step().max_ms() == Approx(1.5));
  CHECK(percentiles_ms(statistics.recent_latency()).p99 == Approx(2.0).epsilon(0.03));
  statistics.tick(now + 5 * kSecond);  // the tracker is silent: what it had is not shown as if it went on
  CHECK(statistics.rate_hz(now + 5 * kSecond) == 0.0);
  CHECK(std::isnan(percentiles_ms(statistics.recent_latency()).p99));
  CHECK(std::isnan(percentiles_ms(statistics.recent_step()).max));
  CHECK(statistics.latency().percentile_ms(0.99) == Approx(2.0));  // of all, in the end
}

TEST_CASE("A daemon with other targets begins a new account, the same one goes on") {
  WatchStatistics statistics = after_frames({1, 2});
  statistics.introduce(sample_hello(), {"T1", "T2"}, {});
  CHECK(statistics.targets()[0].errors.frames == 2);
  statistics.introduce(sample_hello(), {"L1"}, {});
  REQUIRE(statistics.targets().size() == 1);
  CHECK(statistics.targets()[0].errors.frames == 0);
}

TEST_CASE("The page fits terminals of every size") {
  WatchStatistics statistics;
  std::vector<std::string> names;
  for (int i = 0; i < 30; ++i) names.push_back("target" + std::to_string(i));
  statistics.introduce(sample_hello(), names, {"A1"});
  for (std::uint32_t i = 1; i <= 300; ++i) {
    TargetAnswer answer = answer_to(i, 0.001 * i, names.size());
    answer.pads.push_back({0, {1, 2, 2}});
    answer.frame.reasons = protocol::kFewMarkers;
    answer.frame.validity = protocol::Validity::degraded;
    statistics.add_streamed(answer);
    statistics.tick(answer.receive_ns);
  }
  for (std::size_t width = 1; width < 160; ++width) {
    for (const std::size_t height : {6, 12, 24, 60}) {
      const TerminalStyle style{width, height, width % 2 == 0, width % 3 == 0};
      const auto lines = watch_page(statistics, kConnected, style, 5 * kSecond);
      CHECK(lines.size() <= std::max<std::size_t>(height, 12));
      for (const std::string& line : lines) {
        const std::string clipped = clip(line, width);
        REQUIRE(display_width(clipped) <= width);
        if (!style.unicode) REQUIRE(std::ranges::all_of(line, [](char c) { return c >= 0; }));
        if (!style.colour) REQUIRE(line.find('\x1b') == std::string::npos);
      }
    }
  }
}

TEST_CASE("The page says what is known of a target") {
  const WatchStatistics statistics = after_frames({1, 2, 4});
  const TerminalStyle style{100, 24, false, true};
  const std::string page = joined(watch_page(statistics, kConnected, style, 2 * kSecond));
  for (const char* part :
       {"1.2.3", "phantom", "VALID", "frame 4", "1 lost", "T1", "0.20", "0.28", "p50", "2.00", "18 used of 19 seen"}) {
    CHECK_THAT(page, Catch::Contains(part));
  }
}

TEST_CASE("The page says that nobody answers") {
  const TerminalStyle style{80, 24, false, false};
  const std::string page = joined(watch_page({}, {"10.0.0.1:51010", false, 3.0}, style, kSecond));
  CHECK_THAT(page, Catch::Contains("NO ANSWER") && Catch::Contains("10.0.0.1:51010") && Catch::Contains("3 s"));
}

TEST_CASE("Clipping keeps colours and whole characters") {
  CHECK(clip("abc", 2) == "ab");
  CHECK(clip("abc", 3) == "abc");
  CHECK(clip("\x1b[31mabc\x1b[0m", 1) == "\x1b[31ma\x1b[0m");
  CHECK(clip("±±±", 2) == "±±");
  CHECK(display_width("\x1b[2m±95 %\x1b[0m") == 5);
}

TEST_CASE("The summary holds mean and largest error, latency and losses") {
  const std::string text = watch_summary(after_frames({1, 2, 4}), 12.5);
  for (const char* part : {"12.5 s: 3 frames, 1 lost, 100.0 % valid", "T1", "0.200", "100.0 %", "p99 2.00"}) {
    CHECK_THAT(text, Catch::Contains(part));
  }
  const nlohmann::json json = watch_summary_json(after_frames({1, 2, 4}), 12.5);
  CHECK(json["summary"]["frames"] == 3);
  CHECK(json["summary"]["targets"]["T2"]["mean_error_mm"].get<double>() == Approx(0.2));
}
