// Any bytes as a script for a daemon, its contacts, and somebody in between who records, repeats, changes, mixes up and
// makes up datagrams, and who owns one of the keys: whatever opens was sealed, as it stands, and opens once.

#include <sodium.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "protocol/bytes.hpp"
#include "protocol/sealed_contact.hpp"
#include "protocol/sealed_sessions.hpp"
#include "tests/fuzz/promise.hpp"

using namespace tissued::protocol;
using tissued::fuzz::promise;

namespace {

using Bytes = std::vector<std::uint8_t>;

// The same sessions for the same input, so that a finding is one again.
std::mt19937_64 random_numbers;

void fill(void* out, const std::size_t size) {
  auto* bytes = static_cast<std::uint8_t*>(out);
  std::generate_n(bytes, size, [] { return static_cast<std::uint8_t>(random_numbers()); });
}

void make_randomness_repeatable() {
  static randombytes_implementation implementation{[] { return "repeatable"; },
                                                   [] { return static_cast<std::uint32_t>(random_numbers()); },
                                                   nullptr,
                                                   nullptr,
                                                   fill,
                                                   nullptr};
  static const int once = randombytes_set_implementation(&implementation);
  promise(once == 0, "the randomness is ours");
  random_numbers.seed(1);
}

SecretKey key_of(std::uint8_t first) {
  std::array<std::uint8_t, kSecretKeySize> bytes{};
  bytes.fill(first);
  return SecretKey(bytes);
}

// What somebody who owns a key has sealed.
struct Sealed {
  Bytes datagram;
  Bytes payload;
  bool taken = false;  // by the daemon
};

struct Client {
  explicit Client(std::uint16_t port) : address{{}, port}, contact(SealChannel::client, key_of(port % 2 + 1)) {}

  SourceAddress address;
  SealedContact contact;
  std::vector<Bytes> taken;
  SealedSessions::Contact known_as;
};

class Play {
 public:
  explicit Play(std::span<const std::uint8_t> script) : script_(script) { add_client(); }

  void run() {
    while (script_.remaining() > 0 && sealed_.size() < 1000 && clients_.size() < 300) step();
  }

 private:
  void step() {
    switch (script_.u8() % 8) {
      case 0:
        return add_client();
      case 1:
        return seal_first_contact(any_client());
      case 2:
        return seal_question(any_client());
      case 3:
        return seal_answer(any_client());
      case 4:
        return deliver(any_sealed());
      case 5:
        return deliver(changed(any_sealed()));
      case 6:
        return deliver(raw());
      default:
        return forge();
    }
  }

  // One that has made contact, as far as there is room.
  void add_client() {
    clients_.push_back(std::make_unique<Client>(static_cast<std::uint16_t>(clients_.size())));
    Client& client = *clients_.back();
    seal_first_contact(client);
    at_daemon(sealed_.back().datagram, client);
    seal_question(client);
    at_daemon(sealed_.back().datagram, client);
    daemon_.keep(client.known_as, script_.u8() % 4 == 0);
  }

  Client& any_client() { return *clients_[script_.u8() % clients_.size()]; }
  Bytes any_sealed() { return sealed_[script_.u16() % sealed_.size()].datagram; }

  void note(Bytes datagram, std::size_t size, Bytes payload) {
    if (size == 0) return;
    datagram.resize(size);
    sealed_.push_back({std::move(datagram), std::move(payload)});
  }
  void seal_first_contact(Client& client) {
    Bytes out(kMaxSealed);
    const std::size_t size = client.contact.seal_first_contact(out);
    note(out, size, {});
  }
  void seal_question(Client& client) {
    Bytes out(kMaxSealed), payload(script_.u8() * 6U, 'q');
    const std::size_t size = client.contact.seal(payload, out);
    promise((size != 0) == (client.contact.established() && payload.size() <= kMaxDatagram), "seals when established");
    note(out, size, payload);
  }
  void seal_answer(Client& client) {
    Bytes out(kMaxSealed), payload(script_.u8() * 6U, 'a');
    const std::size_t size = daemon_.seal(client.known_as, payload, out);
    promise((size != 0) == (daemon_.has_place(client.known_as) && payload.size() <= kMaxDatagram), "seals to contacts");
    note(out, size, payload);
  }

  // Sessions from any datagrams that went by, or of zeros, under a key of ours.
  void forge() {
    SealHeader one, other;
    if (read_seal_header(any_sealed(), one) != SealRefusal::none) return;
    if (read_seal_header(any_sealed(), other) != SealRefusal::none) return;
    const std::uint8_t how = script_.u8();
    const SecretKey key = key_of((how & 1) != 0 ? 1 : 2);
    SealHeader header{static_cast<SealKind>(how / 64 % 3), seal_key_id(key), one.session, other.session, script_.u64()};
    if ((how & 2) != 0) header.peer_session = other.peer_session;
    if ((how & 4) != 0) header.peer_session = {};
    const auto direction = (how & 8) != 0 ? SealDirection::from_daemon : SealDirection::to_daemon;
    const auto channel = (how & 16) != 0 ? SealChannel::tracker : SealChannel::client;
    Bytes out(kMaxSealed), payload((how & 32) != 0 ? 5 : 0, 'f');
    note(out, seal(seal_key(key, channel, direction), header, payload, out), payload);
  }

  Bytes changed(Bytes datagram) {
    std::uint8_t& byte = datagram[script_.u16() % datagram.size()];
    byte = static_cast<std::uint8_t>(byte ^ script_.u8());
    if (script_.u8() % 8 == 0) datagram.resize(script_.u16() % (kMaxSealed + 2));
    return datagram;
  }
  Bytes raw() {
    const auto bytes = script_.bytes(std::min<std::size_t>(script_.u16() % (kMaxSealed + 2), script_.remaining()));
    return {bytes.begin(), bytes.end()};
  }

  void deliver(const Bytes& datagram) {
    Client& client = any_client();
    if (script_.u8() % 2 == 0) {
      at_daemon(datagram, client);
    } else {
      at_client(datagram, client);
    }
  }

  Sealed* find(const Bytes& datagram) {
    const auto same = [&](const Sealed& sealed) { return sealed.datagram == datagram; };
    const auto found = std::find_if(sealed_.begin(), sealed_.end(), same);
    return found != sealed_.end() ? &*found : nullptr;
  }

  void at_daemon(const Bytes& datagram, Client& client) {
    const auto opened = daemon_.open(datagram, client.address);
    const bool taken = opened.refusal == SealRefusal::none && opened.kind == SealKind::data;
    promise(taken == daemon_.has_place(opened.contact), "who is taken from has a place");
    promise(taken || opened.payload.empty(), "what is refused is not shown");
    promise(opened.challenge.size() <= datagram.size(), "no answer is longer than its question");
    if (!taken && opened.challenge.empty()) return;
    Sealed* sealed = find(datagram);
    promise(sealed != nullptr, "what the daemon takes or answers was sealed");
    if (taken) {
      promise(std::ranges::equal(opened.payload, sealed->payload), "what was sealed comes out");
      promise(!sealed->taken, "the daemon takes a datagram once");
      sealed->taken = true;
      client.known_as = opened.contact;
      return;
    }
    const Bytes challenge(opened.challenge.begin(), opened.challenge.end());
    note(challenge, challenge.size(), {});
    at_client(challenge, client);
  }

  void at_client(const Bytes& datagram, Client& client) {
    const auto opened = client.contact.open(datagram);
    promise(opened.refusal == SealRefusal::none || opened.payload.empty(), "what is refused is not shown");
    if (opened.refusal != SealRefusal::none) return;
    const Sealed* sealed = find(datagram);
    promise(sealed != nullptr, "what a client takes was sealed");
    if (opened.kind != SealKind::data) return;
    promise(std::ranges::equal(opened.payload, sealed->payload), "what was sealed comes out");
    promise(std::ranges::find(client.taken, datagram) == client.taken.end(), "a client takes a datagram once");
    client.taken.push_back(datagram);
  }

  ByteReader script_;
  SealedSessions daemon_{SealChannel::client, std::vector<SealedSessions::Key>{{key_of(1)}, {key_of(2)}}};
  std::vector<std::unique_ptr<Client>> clients_;
  std::vector<Sealed> sealed_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  make_randomness_repeatable();
  Play({data, size}).run();
  return 0;
}
