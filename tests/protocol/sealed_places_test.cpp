// The daemon's table of sealed contacts: whose place is whose, and who loses it.

#include "tests/protocol/sealed_ends.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;

TEST_CASE("a contact is good at its own address alone") {
  Ends ends;
  const auto contact = establish(ends.client, ends.daemon, kHome);
  for (const SourceAddress& elsewhere : {sample_address(2), sample_address(1, 40001)}) {
    const Bytes datagram = sealed(ends.client, Bytes{1});
    const auto opened = ends.daemon.open(datagram, elsewhere);
    CHECK(opened.refusal == SealRefusal::wrong_session);
    CHECK(opened.challenge.size() == 72);
    CHECK(refusal_at(ends.daemon, datagram) == "none");  // was not taken there
  }
  CHECK(ends.daemon.has_place(contact));
  // The client that has really moved is challenged there, and goes on.
  const SourceAddress moved = sample_address(3);
  const auto opened = ends.daemon.open(sealed(ends.client, Bytes{1}), moved);
  ends.client.open(opened.challenge);
  CHECK_FALSE(ends.client.established());
  CHECK(ends.daemon.has_place(establish(ends.client, ends.daemon, moved)));
}

TEST_CASE("no number of contacts that answer no challenge takes a place") {
  Ends ends;
  const Crowd crowd(ends.daemon, SealedSessions::kPlaces);
  for (int i = 0; i < 2000; ++i) {
    SealedContact silent(SealChannel::client, sample_key(0));
    const auto opened = ends.daemon.open(first_contact(silent), sample_address(9, static_cast<std::uint16_t>(i)));
    REQUIRE(opened.challenge.size() == 72);
    // A guessed session is no answer.
    const Bytes guess = forged(sample_key(0), SealDirection::to_daemon,
                               {SealKind::data, {}, sample_session(i), sample_session(i + 1), 1}, {1});
    REQUIRE(ends.daemon.open(guess, kHome).refusal == SealRefusal::wrong_session);
  }
  CHECK(ends.daemon.evicted() == 0);
  for (const auto& contact : crowd.contacts) CHECK(ends.daemon.has_place(contact));
}

TEST_CASE("a full table gives the place of the contact that has been silent for longest") {
  Ends ends;
  Crowd crowd(ends.daemon, SealedSessions::kPlaces);
  CHECK(ends.daemon.evicted() == 0);
  // The first speaks again, so the second is now the longest silent.
  const Bytes recorded = sealed(*crowd.clients[1], Bytes{42});
  const Bytes taken = sealed(*crowd.clients[1], Bytes{43});
  REQUIRE(refusal_at(ends.daemon, taken, crowd.addresses[1]) == "none");
  for (std::size_t i = 0; i < crowd.clients.size(); ++i) {
    if (i != 1) REQUIRE(refusal_at(ends.daemon, sealed(*crowd.clients[i], Bytes{1}), crowd.addresses[i]) == "none");
  }
  const auto newcomer = establish(ends.client, ends.daemon, kHome);
  CHECK(ends.daemon.has_place(newcomer));
  CHECK(ends.daemon.evicted() == 1);
  for (std::size_t i = 0; i < crowd.contacts.size(); ++i) CHECK(ends.daemon.has_place(crowd.contacts[i]) == (i != 1));
  CHECK(sealed(ends.daemon, crowd.contacts[1], Bytes{1}).empty());

  SECTION("nothing the forgotten one sent, taken or not, opens") {
    CHECK(refusal_at(ends.daemon, taken, crowd.addresses[1]) == "wrong_session");
    CHECK(refusal_at(ends.daemon, recorded, crowd.addresses[1]) == "wrong_session");
    // Nor when there is room again and again.
    Crowd more(ends.daemon, 3 * SealedSessions::kPlaces, 5000);
    CHECK(refusal_at(ends.daemon, taken, crowd.addresses[1]) == "wrong_session");
  }
  SECTION("the forgotten one is challenged and comes back") {
    const auto opened = ends.daemon.open(sealed(*crowd.clients[1], Bytes{1}), crowd.addresses[1]);
    CHECK(opened.refusal == SealRefusal::wrong_session);
    crowd.clients[1]->open(opened.challenge);
    CHECK_FALSE(crowd.clients[1]->established());
    CHECK(ends.daemon.has_place(establish(*crowd.clients[1], ends.daemon, crowd.addresses[1])));
    CHECK(ends.daemon.evicted() == 2);
    CHECK(refusal_at(ends.daemon, taken, crowd.addresses[1]) == "wrong_session");
  }
  SECTION("the others go on as before") {
    for (std::size_t i = 2; i < crowd.clients.size(); ++i) {
      CHECK(refusal_at(ends.daemon, sealed(*crowd.clients[i], Bytes{1}), crowd.addresses[i]) == "none");
    }
  }
}

TEST_CASE("a contact that is kept has its place for good, and a table of such is full") {
  Ends ends;
  Crowd crowd(ends.daemon, SealedSessions::kPlaces);
  for (const auto& contact : crowd.contacts) ends.daemon.keep(contact, true);
  ends.client.open(challenge(ends.client, ends.daemon, kHome));
  const Bytes refused = sealed(ends.client, Bytes{1});
  CHECK(refusal_at(ends.daemon, refused) == "table_full");
  CHECK(ends.daemon.open(refused, kHome).challenge.empty());
  CHECK(ends.daemon.evicted() == 0);
  for (const auto& contact : crowd.contacts) CHECK(ends.daemon.has_place(contact));

  ends.daemon.keep(crowd.contacts[5], false);
  CHECK(refusal_at(ends.daemon, refused) == "none");  // was never taken
  CHECK(refusal_at(ends.daemon, refused) == "replayed");
  for (std::size_t i = 0; i < crowd.contacts.size(); ++i) CHECK(ends.daemon.has_place(crowd.contacts[i]) == (i != 5));
  // Whoever has the place now is not kept because the one before was, nor by its name.
  ends.daemon.keep(crowd.contacts[5], true);
  SealedContact next(SealChannel::client, sample_key(1));
  CHECK(ends.daemon.has_place(establish(next, ends.daemon, kHome)));
  CHECK(ends.daemon.evicted() == 2);
}

TEST_CASE("a challenge answered after somebody lost his place is asked once more") {
  Ends ends;
  Crowd crowd(ends.daemon, SealedSessions::kPlaces);
  ends.client.open(challenge(ends.client, ends.daemon, kHome));
  SealedContact faster(SealChannel::client, sample_key(0));
  establish(faster, ends.daemon, sample_address(8));
  CHECK(ends.daemon.evicted() == 1);
  const auto opened = ends.daemon.open(sealed(ends.client, Bytes{1}), kHome);
  CHECK(opened.refusal == SealRefusal::wrong_session);
  ends.client.open(opened.challenge);
  CHECK(ends.daemon.has_place(establish(ends.client, ends.daemon, kHome)));
}

TEST_CASE("a contact from before keys were exchanged is nobody's after it") {
  Ends ends;
  const auto before = establish(ends.client, ends.daemon, kHome);
  const std::vector<SealedSessions::Key> others{{sample_key(1)}};
  SealedSessions after(SealChannel::client, others, ends.daemon.last_serial());
  SealedContact next(SealChannel::client, sample_key(1));
  const auto contact = establish(next, after, sample_address(8));
  CHECK(contact.place == before.place);
  CHECK_FALSE(after.has_place(before));
  CHECK(sealed(after, before, Bytes{1}).empty());
}

TEST_CASE("nobody is no contact") {
  Ends ends;
  CHECK_FALSE(ends.daemon.has_place({}));
  CHECK_FALSE(ends.daemon.has_place({SealedSessions::kPlaces, 1}));
  CHECK(sealed(ends.daemon, {}, Bytes{1}).empty());
  ends.daemon.keep({}, true);
  ends.daemon.keep({SealedSessions::kPlaces, 1}, true);
}
