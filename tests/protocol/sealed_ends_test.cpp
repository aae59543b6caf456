// The two ends of sealed traffic against each other, and against whoever records, holds back, sends back and forges.

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>

#include "tests/protocol/seal_samples.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;

namespace {

const SourceAddress kHome = sample_address(1);

std::vector<SealedSessions::Key> sample_keys() { return {{sample_key(0)}, {sample_key(1)}, {sample_key(2), false}}; }

struct Ends {
  SealedSessions daemon{SealChannel::client, sample_keys()};
  SealedContact client{SealChannel::client, sample_key(0)};
};

std::string refusal_at(SealedSessions& daemon, const Bytes& datagram, const SourceAddress& from = kHome) {
  const auto opened = daemon.open(datagram, from);
  const bool taken = opened.refusal == SealRefusal::none && opened.kind == SealKind::data;
  CHECK(daemon.has_place(opened.contact) == taken);
  if (!taken) CHECK(opened.payload.empty());
  CHECK(opened.challenge.size() <= datagram.size());
  return to_string(opened.refusal);
}

std::string refusal_at(SealedContact& client, const Bytes& datagram) {
  const auto opened = client.open(datagram);
  if (opened.refusal != SealRefusal::none) CHECK(opened.payload.empty());
  return to_string(opened.refusal);
}

Bytes payload_of(const SealedSessions::Opened& opened) { return {opened.payload.begin(), opened.payload.end()}; }

// A datagram such as the owner of the key could make.
Bytes forged(const SecretKey& pre_shared, SealDirection direction, SealHeader header, const Bytes& payload,
             SealChannel channel = SealChannel::client) {
  header.key_id = seal_key_id(pre_shared);
  Bytes datagram(kMaxSealed);
  datagram.resize(seal(seal_key(pre_shared, channel, direction), header, payload, datagram));
  return datagram;
}

SealHeader header_of(const Bytes& datagram) {
  SealHeader header;
  REQUIRE(read_seal_header(datagram, header) == SealRefusal::none);
  return header;
}

// As many established contacts as asked for, each at a port of its own.
struct Crowd {
  explicit Crowd(SealedSessions& daemon, std::size_t count, std::uint16_t first_port = 1000) {
    for (std::size_t i = 0; i < count; ++i) {
      addresses.push_back(sample_address(7, static_cast<std::uint16_t>(first_port + i)));
      clients.push_back(std::make_unique<SealedContact>(SealChannel::client, sample_key(0)));
      contacts.push_back(establish(*clients.back(), daemon, addresses.back()));
    }
  }
  std::vector<SourceAddress> addresses;
  std::vector<std::unique_ptr<SealedContact>> clients;
  std::vector<SealedSessions::Contact> contacts;
};

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
