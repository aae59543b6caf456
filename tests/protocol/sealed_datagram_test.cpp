#include "protocol/sealed_datagram.hpp"

#include <sodium.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <new>
#include <string>

#include "tests/protocol/hex_bytes.hpp"
#include "tests/protocol/seal_samples.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;

namespace {

SealHeader sample_header(SealKind kind = SealKind::data) {
  SealHeader header{kind, seal_key_id(sample_key()), sample_session(0x40), sample_session(0xA0), 2};
  if (kind == SealKind::first_contact) header.peer_session = {};
  return header;
}

SecretKey client_key() { return seal_key(sample_key(), SealChannel::client, SealDirection::to_daemon); }

Bytes sealed_sample(std::span<const std::uint8_t> payload, SealKind kind = SealKind::data) {
  Bytes datagram(kMaxSealed);
  datagram.resize(seal(client_key(), sample_header(kind), payload, datagram));
  return datagram;
}

std::string header_refusal(const Bytes& datagram) {
  SealHeader header;
  return to_string(read_seal_header(datagram, header));
}

bool opens(const SecretKey& key, const Bytes& datagram) {
  SealHeader header;
  std::array<std::uint8_t, kMaxDatagram> payload{};
  return read_seal_header(datagram, header) == SealRefusal::none && unseal(key, datagram, header, payload);
}

Bytes of_hex(const std::string& digits) {
  Bytes bytes(digits.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(std::stoul(digits.substr(2 * i, 2), nullptr, 16));
  }
  return bytes;
}

}  // namespace

TEST_CASE("the cipher is that of draft-irtf-cfrg-xchacha-03, appendix A.3.1") {
  const Bytes key = counting_bytes(32, 0x80), nonce = counting_bytes(24, 0x40);
  const Bytes associated = of_hex("50515253c0c1c2c3c4c5c6c7");
  const std::string text =
      "Ladies and Gentlemen of the class of '99: If I could offer you only one tip for the future, sunscreen would be "
      "it.";
  const Bytes expected = of_hex(
      "bd6d179d3e83d43b9576579493c0e939572a1700252bfaccbed2902c21396cbb"
      "731c7f1b0b4aa6440bf3a82f4eda7e39ae64c6708c54c216cb96b72e1213b452"
      "2f8c9ba40db5d945b11b69b982c1bb9e3f3fac2bc369488f76b2383565d3fff9"
      "21f9664c97637da9768812f615c68b13b52ec0875924c1c7987947deafd8780acf49");
  Bytes sealed(text.size() + kSealTagSize);
  crypto_aead_xchacha20poly1305_ietf_encrypt(sealed.data(), nullptr,
                                             reinterpret_cast<const unsigned char*>(text.data()), text.size(),
                                             associated.data(), associated.size(), nullptr, nonce.data(), key.data());
  CHECK(sealed == expected);
}

TEST_CASE("a sealed datagram is the README's, byte for byte") {
  const Bytes expected = bytes_of_readme("sealed");
  const Bytes payload = bytes_of_readme("subscribe");
  CHECK(sealed_sample(payload) == expected);
  SealHeader header;
  REQUIRE(read_seal_header(expected, header) == SealRefusal::none);
  CHECK(header == sample_header());
  std::array<std::uint8_t, kMaxDatagram> opened{};
  REQUIRE(unseal(client_key(), expected, header, opened));
  CHECK(std::equal(payload.begin(), payload.end(), opened.begin()));
}

TEST_CASE("every payload from nothing to the longest goes in, and one byte more does not") {
  for (std::size_t size = 0; size <= kMaxDatagram; size += size < 70 ? 1 : 19) {
    const Bytes payload = counting_bytes(size, 7);
    const Bytes datagram = sealed_sample(payload);
    REQUIRE(datagram.size() == 72 + size);
    SealHeader header;
    std::array<std::uint8_t, kMaxDatagram> opened{};
    REQUIRE(read_seal_header(datagram, header) == SealRefusal::none);
    REQUIRE(unseal(client_key(), datagram, header, opened));
    REQUIRE(std::equal(payload.begin(), payload.end(), opened.begin()));
  }
  CHECK(sealed_sample(Bytes(kMaxDatagram)).size() == 1472);
  Bytes out(2000);
  CHECK(seal(client_key(), sample_header(), Bytes(kMaxDatagram + 1), out) == 0);
  CHECK(seal(client_key(), sample_header(), Bytes(10), std::span(out).first(81)) == 0);
  CHECK(seal(client_key(), sample_header(), Bytes(10), std::span(out).first(82)) == 82);
}

TEST_CASE("one bit changed anywhere, and a sealed datagram does not open") {
  const Bytes original = sealed_sample(counting_bytes(40, 1));
  REQUIRE(opens(client_key(), original));
  for (std::size_t bit = 0; bit < 8 * original.size(); ++bit) {
    Bytes changed = original;
    changed[bit / 8] = static_cast<std::uint8_t>(changed[bit / 8] ^ (1U << (bit % 8)));
    CAPTURE(bit);
    REQUIRE_FALSE(opens(client_key(), changed));
  }
}

TEST_CASE("cut off at any length, or longer than it was, a sealed datagram does not open") {
  const Bytes original = sealed_sample(counting_bytes(kMaxDatagram, 1));
  for (std::size_t size = 0; size < original.size(); ++size) {
    const Bytes cut(original.begin(), original.begin() + static_cast<std::ptrdiff_t>(size));
    CAPTURE(size);
    REQUIRE_FALSE(opens(client_key(), cut));
    REQUIRE(header_refusal(cut) == (size < 72 ? "too_short" : "none"));
  }
  Bytes longer = sealed_sample(counting_bytes(40, 1));
  longer.push_back(0);
  CHECK_FALSE(opens(client_key(), longer));
}

TEST_CASE("the gates of a sealed header, in their order") {
  const auto refusal_with = [](std::size_t at, int value, SealKind kind = SealKind::data) {
    Bytes datagram = sealed_sample({}, kind);
    datagram[at] = static_cast<std::uint8_t>(value);
    return header_refusal(datagram);
  };
  CHECK(header_refusal({}) == "too_short");
  CHECK(header_refusal(Bytes(71)) == "too_short");
  CHECK(header_refusal(Bytes(1473)) == "too_long");
  CHECK(header_refusal(Bytes(1472)) == "bad_magic");
  for (const std::size_t at : {0, 1, 2, 3}) CHECK(refusal_with(at, 'x') == "bad_magic");
  CHECK(refusal_with(4, 0) == "bad_version");
  CHECK(refusal_with(4, 2) == "bad_version");
  CHECK(refusal_with(5, 3) == "bad_kind");
  CHECK(refusal_with(5, 255) == "bad_kind");
  CHECK(refusal_with(6, 1) == "bad_reserved");
  CHECK(refusal_with(7, 1) == "bad_reserved");
  CHECK(header_refusal(sealed_sample(Bytes(1), SealKind::first_contact)) == "wrong_size");
  CHECK(header_refusal(sealed_sample(Bytes(1), SealKind::challenge)) == "wrong_size");
  CHECK(refusal_with(5, 1) == "bad_session");                           // a first contact that knows its peer
  CHECK(refusal_with(5, 0, SealKind::first_contact) == "bad_session");  // data that do not
  CHECK(refusal_with(5, 2, SealKind::first_contact) == "bad_session");  // nor a challenge
  Bytes nobody = sealed_sample({});
  std::fill_n(nobody.begin() + 16, 16, std::uint8_t{0});
  CHECK(header_refusal(nobody) == "bad_session");
  for (const SealKind kind : {SealKind::data, SealKind::first_contact, SealKind::challenge}) {
    CHECK(header_refusal(sealed_sample({}, kind)) == "none");
  }
}

TEST_CASE("a header that is refused leaves the reader's as it was") {
  SealHeader header = sample_header();
  header.counter = 99;
  const SealHeader before = header;
  Bytes datagram = sealed_sample({});
  datagram[5] = 1;
  CHECK(read_seal_header(datagram, header) == SealRefusal::bad_session);
  CHECK(header == before);
}

TEST_CASE("every channel and direction, and every key, has a key of its own") {
  std::vector<SecretKey> keys;
  for (const int first : {0, 1}) {
    for (const SealChannel channel : {SealChannel::tracker, SealChannel::client}) {
      for (const SealDirection direction : {SealDirection::to_daemon, SealDirection::from_daemon}) {
        keys.push_back(seal_key(sample_key(first), channel, direction));
      }
    }
  }
  Bytes datagram(kMaxSealed);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    datagram.resize(kMaxSealed);
    datagram.resize(seal(keys[i], sample_header(), Bytes{1, 2, 3}, datagram));
    for (std::size_t k = 0; k < keys.size(); ++k) CHECK(opens(keys[k], datagram) == (i == k));
  }
}

TEST_CASE("refusals have names of their own") {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kSealRefusalCount; ++i) names.push_back(to_string(static_cast<SealRefusal>(i)));
  CHECK(std::string(to_string(static_cast<SealRefusal>(kSealRefusalCount))) == "unknown");
  std::sort(names.begin(), names.end());
  CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
  CHECK(std::find(names.begin(), names.end(), "unknown") == names.end());
}

TEST_CASE("a secret key is wiped when it is dropped") {
  alignas(SecretKey) std::array<unsigned char, sizeof(SecretKey)> memory{};
  auto* key = new (memory.data()) SecretKey(sample_key(1));
  const volatile unsigned char* seen = memory.data();
  REQUIRE(seen[0] == 1);
  key->~SecretKey();
  for (std::size_t i = 0; i < memory.size(); ++i) CHECK(seen[i] == 0);
}

TEST_CASE("keys are drawn anew") {
  const SecretKey a = SecretKey::random(), b = SecretKey::random();
  CHECK_FALSE(std::equal(a.bytes().begin(), a.bytes().end(), b.bytes().begin()));
}
