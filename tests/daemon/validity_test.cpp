#include "daemon/validity.hpp"

#include <catch2/catch.hpp>
#include <chrono>

using namespace tissued;
using daemon::Answer;
using daemon::judge;
using daemon::Verdict;
using protocol::Validity;
using protocol::ValidityReason;
using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kMs = 1'000'000;
const config::StalenessConfig kStaleness{100ms, 400ms};

Answer answer_of(std::uint16_t reasons) {
  Answer answer;
  answer.has_frame = true;
  answer.receive_ns = 1000 * kMs;
  answer.reasons = reasons;
  return answer;
}

}  // namespace

TEST_CASE("Without a frame there is no data, however long") {
  CHECK(judge(Answer{}, 0, kStaleness).validity == Validity::no_data);
  CHECK(judge(Answer{}, ~std::uint64_t{0}, kStaleness).validity == Validity::no_data);
  CHECK(judge(Answer{}, ~std::uint64_t{0}, kStaleness).age_ns == 0);
}

TEST_CASE("An answer ages: valid, stale, lost") {
  const Answer answer = answer_of(0);
  const auto at = [&](std::uint64_t age_ms) { return judge(answer, (1000 + age_ms) * kMs, kStaleness); };
  CHECK(at(0).validity == Validity::valid);
  CHECK(at(100).validity == Validity::valid);
  CHECK(at(100).reasons == 0);
  CHECK(at(101).validity == Validity::degraded);
  CHECK(at(101).reasons == ValidityReason::kTrackerSilent);
  CHECK(at(400).validity == Validity::degraded);
  CHECK(at(401).validity == Validity::invalid);
  CHECK(at(401).reasons == ValidityReason::kTrackerSilent);
  CHECK(at(60'000).age_ns == 60'000 * kMs);
}

TEST_CASE("A frame stamped after now is of age zero") {
  const Verdict verdict = judge(answer_of(0), 999 * kMs, kStaleness);
  CHECK(verdict.age_ns == 0);
  CHECK(verdict.validity == Validity::valid);
}

TEST_CASE("Reasons degrade, a step thrown away or a missing registration makes invalid") {
  for (unsigned bit = 0; bit < protocol::kValidityReasonCount; ++bit) {
    const auto reason = static_cast<std::uint16_t>(1u << bit);
    const bool fatal = reason == ValidityReason::kDiverged || reason == ValidityReason::kNotRegistered;
    const Verdict verdict = judge(answer_of(reason), 1000 * kMs, kStaleness);
    CHECK(verdict.validity == (fatal ? Validity::invalid : Validity::degraded));
    CHECK(verdict.reasons == reason);
  }
}
