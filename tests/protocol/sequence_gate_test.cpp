#include "protocol/sequence_gate.hpp"

#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <string>

using namespace tissued::protocol;

namespace {

SequenceVerdict judge(SequenceGate& gate, std::uint32_t sequence, std::uint32_t session = 1) {
  return gate.judge({session, sequence, 0});
}

}  // namespace

TEST_CASE("ascending sequence numbers pass, gaps are lost until they come late") {
  SequenceGate gate;
  CHECK(judge(gate, 10) == SequenceVerdict::first);
  CHECK(judge(gate, 11) == SequenceVerdict::next);
  CHECK(gate.lost() == 0);
  CHECK(judge(gate, 15) == SequenceVerdict::next);
  CHECK(gate.lost() == 3);
  CHECK(judge(gate, 13) == SequenceVerdict::late);
  CHECK(gate.lost() == 2);
  CHECK(judge(gate, 13) == SequenceVerdict::duplicate);
  CHECK(judge(gate, 15) == SequenceVerdict::duplicate);
  CHECK(judge(gate, 9) == SequenceVerdict::late);  // before the first: never missed
  CHECK(gate.lost() == 2);
}

TEST_CASE("the window holds 64 numbers") {
  SequenceGate gate;
  judge(gate, 100);
  judge(gate, 200);
  CHECK(judge(gate, 137) == SequenceVerdict::late);
  CHECK(judge(gate, 137) == SequenceVerdict::duplicate);
  CHECK(judge(gate, 136) == SequenceVerdict::too_old);
  CHECK(judge(gate, 100) == SequenceVerdict::too_old);
  CHECK(judge(gate, 201) == SequenceVerdict::next);
  CHECK(judge(gate, 137) == SequenceVerdict::too_old);
}

TEST_CASE("a gap as long as the window leaves nothing in it") {
  SequenceGate gate;
  judge(gate, 99);
  judge(gate, 100);
  judge(gate, 164);
  CHECK(judge(gate, 163) == SequenceVerdict::late);
  CHECK(judge(gate, 101) == SequenceVerdict::late);
}

TEST_CASE("sequence numbers wrap around") {
  SequenceGate gate;
  judge(gate, 0xFFFFFFFE);
  CHECK(judge(gate, 1) == SequenceVerdict::next);
  CHECK(gate.lost() == 2);
  CHECK(judge(gate, 0xFFFFFFFF) == SequenceVerdict::late);
  CHECK(judge(gate, 0) == SequenceVerdict::late);
  CHECK(judge(gate, 0xFFFFFFFE) == SequenceVerdict::duplicate);
  CHECK(gate.lost() == 0);
}

TEST_CASE("a new session starts afresh") {
  SequenceGate gate;
  judge(gate, 1000);
  judge(gate, 1010);
  CHECK(judge(gate, 3, 2) == SequenceVerdict::first);
  CHECK(gate.lost() == 0);
  CHECK(judge(gate, 4, 2) == SequenceVerdict::next);
}

TEST_CASE("the gate agrees with a set that forgets nothing") {
  std::mt19937 random(3);
  for (const std::uint32_t origin : {0U, 0xFFFFFF00U}) {
    SequenceGate gate;
    std::set<std::int64_t> seen;
    std::int64_t base = 1000;
    for (int i = 0; i < 20000; ++i) {
      base += std::uniform_int_distribution<int>(0, 2)(random);
      const std::int64_t number = base - std::uniform_int_distribution<int>(0, 80)(random);
      SequenceVerdict expected = SequenceVerdict::first;
      if (!seen.empty()) {
        const std::int64_t newest = *seen.rbegin();
        expected = number > newest          ? SequenceVerdict::next
                   : number + 63 < newest   ? SequenceVerdict::too_old
                   : seen.count(number) > 0 ? SequenceVerdict::duplicate
                                            : SequenceVerdict::late;
      }
      const SequenceVerdict verdict = judge(gate, origin + static_cast<std::uint32_t>(number));
      REQUIRE(std::string(to_string(verdict)) == to_string(expected));
      if (expected != SequenceVerdict::too_old) seen.insert(number);
    }
  }
}
