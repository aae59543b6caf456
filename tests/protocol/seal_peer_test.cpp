// Our sealed datagrams and cookies against seal_peer.py, which was written from protocol/README.md and the drafts and
// knows nothing of our code, nor of libsodium.

#include <catch2/catch.hpp>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "protocol/address_cookie.hpp"
#include "tests/protocol/seal_samples.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;

namespace {

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02x", byte);
    text += digits.data();
  }
  return text.empty() ? "-" : text;
}

Bytes of_hex(const std::string& digits) {
  if (digits == "-") return {};
  Bytes bytes(digits.size() / 2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::uint8_t>(std::stoul(digits.substr(2 * i, 2), nullptr, 16));
  }
  return bytes;
}

// The words that the peer prints.
std::vector<std::string> ask_peer(const std::string& arguments) {
  const std::string command =
      std::string(TISSUED_PYTHON) + " " + TISSUED_SOURCE_DIR + "/tests/protocol/seal_peer.py " + arguments;
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string text;
  for (int byte = std::fgetc(pipe); byte != EOF; byte = std::fgetc(pipe)) text += static_cast<char>(byte);
  REQUIRE(pclose(pipe) == 0);
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::string sample_key_hex() { return hex(sample_key().bytes()); }

const SourceAddress kHome = sample_address(1);

}  // namespace

TEST_CASE("the peer's cipher is that of the draft") { CHECK(ask_peer("check") == std::vector<std::string>{"ok"}); }

TEST_CASE("the peer names a key as we do") {
  CHECK(ask_peer("id " + sample_key_hex()) == std::vector{hex(seal_key_id(sample_key()))});
}

TEST_CASE("what we seal is, byte for byte, what the peer seals, for every channel, direction and kind") {
  const std::string session = hex(sample_session(3)), peer_session = hex(sample_session(90));
  struct Way {
    SealChannel channel;
    SealDirection direction;
    const char* label;
  };
  const Way ways[] = {{SealChannel::tracker, SealDirection::to_daemon, "TSEA1 tracker to daemon"},
                      {SealChannel::tracker, SealDirection::from_daemon, "TSEA1 daemon to tracker"},
                      {SealChannel::client, SealDirection::to_daemon, "TSEA1 client to daemon"},
                      {SealChannel::client, SealDirection::from_daemon, "TSEA1 daemon to client"}};
  for (const Way& way : ways) {
    CAPTURE(way.label);
    std::string payloads;
    const std::size_t sizes[] = {0, 1, 15, 16, 17, 63, 64, 65, 1024, 1399, 1400};
    for (const std::size_t size : sizes) payloads += ' ' + hex(counting_bytes(size, 11));
    const auto theirs = ask_peer("seal " + sample_key_hex() + " '" + way.label + "' 0 " + session + ' ' + peer_session +
                                 " 72623859790382856" + payloads);
    REQUIRE(theirs.size() == std::size(sizes));
    const SecretKey key = seal_key(sample_key(), way.channel, way.direction);
    const SealHeader header{SealKind::data, seal_key_id(sample_key()), sample_session(3), sample_session(90),
                            72623859790382856U};
    for (std::size_t i = 0; i < theirs.size(); ++i) {
      Bytes datagram(kMaxSealed);
      datagram.resize(seal(key, header, counting_bytes(sizes[i], 11), datagram));
      CHECK(hex(datagram) == theirs[i]);
    }
  }
}

TEST_CASE("the peer makes contact with our daemon, asks and is answered") {
  SealedSessions daemon(SealChannel::client, std::vector<SealedSessions::Key>{{sample_key()}});
  const std::string to_daemon = sample_key_hex() + " 'TSEA1 client to daemon' ";
  const std::string to_client = sample_key_hex() + " 'TSEA1 daemon to client' ";
  const std::string session = hex(sample_session(200)), nobody(32, '0');
  const auto question = ask_peer("seal " + to_daemon + "1 " + session + ' ' + nobody + " 1 -");
  const auto asked = daemon.open(of_hex(question.at(0)), kHome);
  REQUIRE(asked.refusal == SealRefusal::none);
  const auto told = ask_peer("open " + to_client + hex(asked.challenge));
  REQUIRE(told.size() == 5);
  CHECK(told[0] == "2");
  CHECK(told[2] == session);
  CHECK(told[4] == "-");
  const auto request = ask_peer("seal " + to_daemon + "0 " + session + ' ' + told[1] + " 2 c0ffee");
  const auto opened = daemon.open(of_hex(request.at(0)), kHome);
  REQUIRE(opened.refusal == SealRefusal::none);
  CHECK(hex(opened.payload) == "c0ffee");
  const auto answer = ask_peer("open " + to_client + hex(sealed(daemon, opened.contact, Bytes{0xAB, 0xCD})));
  REQUIRE(answer.size() == 5);
  CHECK(answer[0] == "0");
  CHECK(answer[1] == told[1]);
  CHECK(answer[2] == session);
  CHECK(std::stoull(answer[3]) > std::stoull(told[3]));
  CHECK(answer[4] == "abcd");
}

TEST_CASE("our tracker end makes contact with a daemon of the peer") {
  SealedContact contact(SealChannel::tracker, sample_key());
  const std::string to_daemon = sample_key_hex() + " 'TSEA1 tracker to daemon' ";
  const std::string to_tracker = sample_key_hex() + " 'TSEA1 daemon to tracker' ";
  const std::string session = hex(sample_session(150));
  const auto asked = ask_peer("open " + to_daemon + hex(first_contact(contact)));
  REQUIRE(asked.size() == 5);
  CHECK(asked[0] == "1");
  CHECK(asked[2] == std::string(32, '0'));
  const auto challenge = ask_peer("seal " + to_tracker + "2 " + session + ' ' + asked[1] + " 1 -");
  REQUIRE(contact.open(of_hex(challenge.at(0))).refusal == SealRefusal::none);
  REQUIRE(contact.established());
  const auto data = ask_peer("open " + to_daemon + hex(sealed(contact, counting_bytes(1024, 0))));
  REQUIRE(data.size() == 5);
  CHECK(data[0] == "0");
  CHECK(data[1] == asked[1]);
  CHECK(data[2] == session);
  CHECK(data[4] == hex(counting_bytes(1024, 0)));
}

TEST_CASE("our cookies are those of the peer") {
  const AddressCookie cookies(sample_key());
  const auto theirs = ask_peer("cookie " + sample_key_hex() + ' ' + hex(kHome.ip) + " 40000 12345");
  CHECK(theirs == std::vector{hex(cookies.make(kHome, 12345 * AddressCookie::kEpoch_ns + 17))});
}
