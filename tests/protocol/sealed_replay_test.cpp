// Sealed traffic against whoever records, holds back and sends again: nothing is taken twice, nor after a restart.

#include <algorithm>
#include <random>
#include <set>

#include "tests/protocol/sealed_ends.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;

TEST_CASE("each end takes a datagram once, in any order within the window") {
  Ends ends;
  const auto contact = establish(ends.client, ends.daemon, kHome);
  std::vector<Bytes> up, down;
  for (int i = 0; i < 1200; ++i) {
    up.push_back(sealed(ends.client, Bytes{static_cast<std::uint8_t>(i)}));
    down.push_back(sealed(ends.daemon, contact, Bytes{static_cast<std::uint8_t>(i)}));
  }
  CHECK(refusal_at(ends.daemon, up[1199]) == "none");
  CHECK(refusal_at(ends.client, down[1199]) == "none");
  for (std::size_t i = 1200; i-- > 0;) {
    const std::string expected = i == 1199 ? "replayed" : i + 1024 > 1199 ? "none" : "too_old";
    REQUIRE(refusal_at(ends.daemon, up[i]) == expected);
    REQUIRE(refusal_at(ends.client, down[i]) == expected);
  }
  for (const Bytes& datagram : up) REQUIRE(refusal_at(ends.daemon, datagram) != "none");
  for (const Bytes& datagram : down) REQUIRE(refusal_at(ends.client, datagram) != "none");
}

TEST_CASE("nothing recorded before a restart of the daemon opens after it") {
  Ends ends;
  establish(ends.client, ends.daemon, kHome);
  std::vector<Bytes> recorded;  // never arrived
  for (int i = 0; i < 10; ++i) recorded.push_back(sealed(ends.client, Bytes{1}));
  SealedSessions restarted(SealChannel::client, sample_keys());
  for (const Bytes& datagram : recorded) CHECK(refusal_at(restarted, datagram) == "wrong_session");
  CHECK(restarted.evicted() == 0);
}

TEST_CASE("a client finds its way back to a daemon that has restarted") {
  Ends ends;
  const auto contact = establish(ends.client, ends.daemon, kHome);
  const Bytes held_back = sealed(ends.daemon, contact, Bytes{7});
  SealedSessions restarted(SealChannel::client, sample_keys());
  std::vector<Bytes> challenges;
  for (int i = 0; i < 3; ++i) {
    const auto opened = restarted.open(sealed(ends.client, Bytes{1}), kHome);
    REQUIRE(opened.refusal == SealRefusal::wrong_session);
    challenges.emplace_back(opened.challenge.begin(), opened.challenge.end());
  }
  CHECK(refusal_at(ends.client, challenges[0]) == "none");
  CHECK_FALSE(ends.client.established());
  CHECK(ends.client.lost_contacts() == 1);
  // The other challenges were for the contact that has just been given up.
  CHECK(refusal_at(ends.client, challenges[1]) == "wrong_session");
  CHECK_FALSE(ends.client.established());
  const auto again = establish(ends.client, restarted, kHome);
  CHECK(restarted.has_place(again));
  CHECK(refusal_at(ends.client, challenges[2]) == "wrong_session");
  CHECK(refusal_at(ends.client, held_back) == "wrong_session");
  CHECK(ends.client.established());
  CHECK(ends.client.lost_contacts() == 1);
}

TEST_CASE("a challenge that was held back costs an established client a new contact, and opens nothing old") {
  Ends ends;
  const Bytes held_back = challenge(ends.client, ends.daemon, kHome);  // of this contact, by the daemon before
  SealedSessions restarted(SealChannel::client, sample_keys());
  const auto contact = establish(ends.client, restarted, kHome);
  const Bytes old = sealed(restarted, contact, Bytes{1});
  CHECK(refusal_at(ends.client, old) == "none");
  CHECK(refusal_at(ends.client, held_back) == "none");
  CHECK_FALSE(ends.client.established());
  CHECK(refusal_at(ends.client, held_back) == "wrong_session");
  establish(ends.client, restarted, kHome);
  CHECK(ends.client.established());
  CHECK(refusal_at(ends.client, old) == "wrong_session");
}

TEST_CASE("the same challenge twice, or another of the same daemon, changes nothing") {
  Ends ends;
  const Bytes one = challenge(ends.client, ends.daemon, kHome), two = challenge(ends.client, ends.daemon, kHome);
  for (const Bytes& datagram : {one, two, one}) {
    CHECK(refusal_at(ends.client, datagram) == "none");
    CHECK(ends.client.established());
  }
  CHECK(ends.client.lost_contacts() == 0);
  const auto contact = establish(ends.client, ends.daemon, kHome);
  CHECK(ends.client.lost_contacts() == 0);
  CHECK(refusal_at(ends.client, sealed(ends.daemon, contact, Bytes{1})) == "none");
}

TEST_CASE("nothing recorded before a restart of the client opens after it") {
  Ends ends;
  const Bytes told = challenge(ends.client, ends.daemon, kHome);
  const auto contact = establish(ends.client, ends.daemon, kHome);
  const Bytes answer = sealed(ends.daemon, contact, Bytes{1});
  SealedContact restarted(SealChannel::client, sample_key(0));
  for (const bool established : {false, true}) {
    if (established) establish(restarted, ends.daemon, kHome);
    CHECK(refusal_at(restarted, told) == "wrong_session");
    CHECK(refusal_at(restarted, answer) == "wrong_session");
    CHECK(restarted.established() == established);
  }
}

TEST_CASE("no session and counter come twice under one key, whoever is sent to") {
  Ends ends;
  std::set<std::pair<SealSession, std::uint64_t>> up, down;
  Crowd crowd(ends.daemon, 70);  // six of them lose their places
  const auto note = [](auto& seen, const Bytes& datagram) {
    if (datagram.empty()) return;
    const SealHeader header = header_of(datagram);
    REQUIRE(seen.insert({header.session, header.counter}).second);
  };
  for (int round = 0; round < 10; ++round) {
    for (std::size_t i = 0; i < crowd.clients.size(); ++i) {
      // Every succession of challenge and data toward the same contact.
      for (const char kind : {'c', 'c', 'd', 'd', 'c', 'd'}) {
        const Bytes question = kind == 'c' ? first_contact(*crowd.clients[i]) : sealed(*crowd.clients[i], Bytes{1});
        const auto opened = ends.daemon.open(question, crowd.addresses[i]);
        note(up, question);
        note(down, {opened.challenge.begin(), opened.challenge.end()});
        if (kind == 'd') note(down, sealed(ends.daemon, crowd.contacts[i], Bytes{1}));
      }
    }
  }
  CHECK(up.size() == 10 * 70 * 6);
  CHECK(down.size() == 10 * 70 * 6);  // those without a place are challenged where the others are answered
}

TEST_CASE("over a lossy, reordering and repeating way every datagram is taken at most once, and contact is made") {
  std::mt19937 random(5);
  Ends ends;
  std::vector<Bytes> way;  // to the daemon
  std::vector<int> taken(4000, 0);
  int sent = 0;
  for (int i = 0; i < 4000; ++i) {
    if (!ends.client.established()) {
      way.push_back(first_contact(ends.client));
    } else {
      way.push_back(sealed(ends.client, Bytes{static_cast<std::uint8_t>(sent), static_cast<std::uint8_t>(sent >> 8)}));
      ++sent;
    }
    const Bytes datagram = way[std::uniform_int_distribution<std::size_t>(
        way.size() - std::min<std::size_t>(way.size(), 1500), way.size() - 1)(random)];
    const auto opened = ends.daemon.open(datagram, kHome);
    if (!opened.challenge.empty() && random() % 3 == 0) ends.client.open(opened.challenge);
    if (opened.payload.size() == 2) ++taken[opened.payload[0] + 256U * opened.payload[1]];
  }
  CHECK(sent > 3000);
  CHECK(std::count(taken.begin(), taken.end(), 1) > 1000);
  CHECK(std::count_if(taken.begin(), taken.end(), [](int times) { return times > 1; }) == 0);
}
