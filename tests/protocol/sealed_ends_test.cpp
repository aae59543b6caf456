// The two ends of sealed traffic against each other, and against whoever changes, forges and sends back.

#include <limits>

#include "tests/protocol/sealed_ends.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;

namespace {

Bytes payload_of(const SealedSessions::Opened& opened) { return {opened.payload.begin(), opened.payload.end()}; }

}  // namespace

TEST_CASE("first contact, challenge, then data both ways") {
  Ends ends;
  CHECK_FALSE(ends.client.established());
  CHECK(sealed(ends.client, Bytes{1}).empty());
  const auto asked = ends.daemon.open(first_contact(ends.client), kHome);
  CHECK(asked.refusal == SealRefusal::none);
  CHECK(asked.kind == SealKind::first_contact);
  CHECK(asked.payload.empty());
  CHECK_FALSE(ends.daemon.has_place(asked.contact));
  const auto told = ends.client.open(asked.challenge);
  CHECK(told.refusal == SealRefusal::none);
  CHECK(told.kind == SealKind::challenge);
  REQUIRE(ends.client.established());

  SealedSessions::Contact contact;
  for (const std::size_t size : {0U, 1U, 36U, 1400U}) {
    const Bytes question = counting_bytes(size, 3), answer = counting_bytes(1400 - size, 5);
    const auto opened = ends.daemon.open(sealed(ends.client, question), kHome);
    REQUIRE(opened.refusal == SealRefusal::none);
    CHECK(opened.kind == SealKind::data);
    CHECK(opened.key == 0);
    CHECK(opened.challenge.empty());
    CHECK(payload_of(opened) == question);
    contact = opened.contact;
    const Bytes sent = sealed(ends.daemon, contact, answer);
    const auto received = ends.client.open(sent);
    REQUIRE(received.refusal == SealRefusal::none);
    CHECK(Bytes(received.payload.begin(), received.payload.end()) == answer);
  }
  CHECK(sealed(ends.client, Bytes(1401)).empty());
  CHECK(sealed(ends.daemon, contact, Bytes(1401)).empty());
}

TEST_CASE("the daemon says which key it was") {
  Ends ends;
  SealedContact other(SealChannel::client, sample_key(1));
  other.open(challenge(other, ends.daemon, kHome));
  const auto opened = ends.daemon.open(sealed(other, Bytes{1}), kHome);
  CHECK(opened.refusal == SealRefusal::none);
  CHECK(opened.key == 1);
}

TEST_CASE("a key that is not known, or is for other things, opens nothing and is not answered") {
  Ends ends;
  SealedContact stranger(SealChannel::client, sample_key(9));
  SealedContact tracker_only(SealChannel::client, sample_key(2));
  for (const auto& [contact, refusal] : {std::pair(&stranger, "unknown_key"), std::pair(&tracker_only, "wrong_role")}) {
    const Bytes datagram = first_contact(*contact);
    CHECK(refusal_at(ends.daemon, datagram) == refusal);
    CHECK(ends.daemon.open(datagram, kHome).challenge.empty());
  }
  CHECK(refusal_at(ends.client, forged(sample_key(1), SealDirection::from_daemon,
                                       {SealKind::data, {}, sample_session(1), sample_session(2), 1}, {})) ==
        "unknown_key");
}

TEST_CASE("a datagram of one channel does not open on the other") {
  SealedSessions clients(SealChannel::client, sample_keys()), trackers(SealChannel::tracker, sample_keys());
  SealedContact client(SealChannel::client, sample_key(0));
  establish(client, clients, kHome);
  CHECK(refusal_at(trackers, sealed(client, Bytes{1})) == "bad_tag");
  CHECK(refusal_at(trackers, first_contact(client)) == "bad_tag");
}

TEST_CASE("what is sent back to its own sender does not open") {
  Ends ends;
  const Bytes question = first_contact(ends.client);
  const Bytes answer = challenge(ends.client, ends.daemon, kHome);
  const auto contact = establish(ends.client, ends.daemon, kHome);
  const Bytes up = sealed(ends.client, Bytes{1}), down = sealed(ends.daemon, contact, Bytes{2});
  CHECK(refusal_at(ends.client, question) == "bad_kind");
  CHECK(refusal_at(ends.client, up) == "bad_tag");
  CHECK(refusal_at(ends.daemon, answer) == "bad_kind");
  CHECK(refusal_at(ends.daemon, down) == "bad_tag");
  // Nor to another client of the same key, nor to another daemon.
  SealedContact sibling(SealChannel::client, sample_key(0));
  SealedSessions other(SealChannel::client, sample_keys());
  CHECK(refusal_at(sibling, up) == "bad_tag");
  CHECK(refusal_at(sibling, down) == "wrong_session");
  CHECK(refusal_at(other, down) == "bad_tag");
  CHECK(refusal_at(other, up) == "wrong_session");
}

TEST_CASE("at either end one bit changed anywhere is refused, and the original still opens") {
  Ends ends;
  const auto contact = establish(ends.client, ends.daemon, kHome);
  const Bytes up = sealed(ends.client, counting_bytes(36, 1));
  const Bytes down = sealed(ends.daemon, contact, counting_bytes(36, 1));
  for (std::size_t bit = 0; bit < 8 * up.size(); ++bit) {
    CAPTURE(bit);
    const auto flipped = [bit](Bytes datagram) {
      datagram[bit / 8] = static_cast<std::uint8_t>(datagram[bit / 8] ^ (1U << (bit % 8)));
      return datagram;
    };
    REQUIRE(refusal_at(ends.daemon, flipped(up)) != "none");
    REQUIRE(ends.daemon.open(flipped(up), kHome).challenge.empty());
    REQUIRE(refusal_at(ends.client, flipped(down)) != "none");
  }
  CHECK(refusal_at(ends.daemon, up) == "none");
  CHECK(refusal_at(ends.client, down) == "none");
}

TEST_CASE("cut off at any length, nothing opens and nothing is answered") {
  Ends ends;
  establish(ends.client, ends.daemon, kHome);
  for (const Bytes& whole : {sealed(ends.client, counting_bytes(200, 1)), first_contact(ends.client)}) {
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto opened = ends.daemon.open(std::span(whole).first(size), kHome);
      REQUIRE(opened.refusal == (size < 72 ? SealRefusal::too_short : SealRefusal::bad_tag));
      REQUIRE(opened.challenge.empty());
    }
  }
}

TEST_CASE("a client takes data from the daemon it is in contact with, and from no other owner of the key") {
  Ends ends;
  const SealSession own = header_of(first_contact(ends.client)).session;
  const auto from = [&](const SealSession& session) {
    return forged(sample_key(0), SealDirection::from_daemon, {SealKind::data, {}, session, own, 1000}, {1});
  };
  CHECK(refusal_at(ends.client, from(sample_session(1))) == "wrong_session");  // before there is any contact
  const auto contact = establish(ends.client, ends.daemon, kHome);
  CHECK(refusal_at(ends.client, from(sample_session(1))) == "wrong_session");
  const SealSession theirs = header_of(sealed(ends.daemon, contact, Bytes{1})).session;
  CHECK(refusal_at(ends.client, from(theirs)) == "none");
}

TEST_CASE("the owner of a key spoils no contact but his own") {
  Ends ends;
  const auto victim = establish(ends.client, ends.daemon, kHome);
  SealedContact rogue(SealChannel::client, sample_key(1));
  establish(rogue, ends.daemon, sample_address(2));
  SealHeader last = header_of(sealed(rogue, Bytes{1}));
  last.counter = std::numeric_limits<std::uint64_t>::max();
  CHECK(refusal_at(ends.daemon, forged(sample_key(1), SealDirection::to_daemon, last, {1}), sample_address(2)) ==
        "none");
  CHECK(refusal_at(ends.daemon, sealed(rogue, Bytes{1}), sample_address(2)) == "too_old");
  // The victim's sessions under another key are another contact's.
  const SealHeader borrowed = header_of(sealed(ends.client, Bytes{1}));
  CHECK(refusal_at(ends.daemon, forged(sample_key(1), SealDirection::to_daemon, borrowed, {1})) == "wrong_session");
  CHECK(ends.daemon.has_place(victim));
  CHECK(refusal_at(ends.daemon, sealed(ends.client, Bytes{1})) == "none");
}
