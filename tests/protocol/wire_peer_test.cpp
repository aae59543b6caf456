// Our codecs against wire_peer.py, which was written from protocol/README.md and knows nothing of our encoder.

#include <catch2/catch.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "protocol/bytes.hpp"
#include "protocol/client_messages.hpp"
#include "protocol/frame_assembler.hpp"
#include "protocol/vicon_stream.hpp"
#include "tests/protocol/client_samples.hpp"

using namespace tissued::protocol;

namespace {

std::vector<std::vector<std::uint8_t>> datagrams_of_peer(const std::string& protocol) {
  const std::string command =
      std::string(TISSUED_PYTHON) + " " + TISSUED_SOURCE_DIR + "/tests/protocol/wire_peer.py " + protocol;
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::vector<std::uint8_t> all;
  for (int byte = std::fgetc(pipe); byte != EOF; byte = std::fgetc(pipe)) {
    all.push_back(static_cast<std::uint8_t>(byte));
  }
  REQUIRE(pclose(pipe) == 0);
  std::vector<std::vector<std::uint8_t>> datagrams;
  ByteReader reader(all);
  while (reader.remaining() > 0) {
    const auto datagram = reader.bytes(reader.u32());
    REQUIRE(reader.ok());
    datagrams.emplace_back(datagram.begin(), datagram.end());
  }
  return datagrams;
}

}  // namespace

TEST_CASE("blocks of a Vicon Tracker, packed by the peer, become frames") {
  const auto datagrams = datagrams_of_peer("tracker");
  REQUIRE(datagrams.size() == 40);
  FrameAssembler assembler(
      {.markers = {Name::from("A4").value()}, .objects = {Name::from("A0").value(), Name::from("A3").value()}});
  std::uint32_t k = 0;
  for (const auto& bytes : datagrams) {
    TrackerDatagram datagram;
    REQUIRE(decode_tracker_datagram(bytes, datagram) == TrackerRefusal::none);
    for (const TrackerFrame& frame : assembler.add(datagram, 10'000'000ULL * k)) {
      CHECK(frame.frame_number == 4294967290U + k);
      CHECK(frame.completion == FrameCompletion::all_names);
      REQUIRE(frame.objects.size() == 4);
      for (int i = 0; i < 4; ++i) {
        CHECK(frame.objects[i].name.view() == std::string("A").append(std::to_string(i)));
        CHECK(frame.objects[i].position == std::array{k + 0.5, -1.0 * i, 100.0 * i + k});
        CHECK(frame.objects[i].rotation_rad == std::array{0.001 * k, -0.125 * i, 3.0});
      }
      REQUIRE(frame.markers.size() == 1);
      CHECK(frame.markers[0].position == std::array{k + 0.5, -4.0, 400.0 + k});
      ++k;
    }
  }
  CHECK(k == 20);
}

TEST_CASE("every client message is, byte for byte, what the peer packs, and is read back from it") {
  const auto datagrams = datagrams_of_peer("client");
  const auto samples = client_samples();
  REQUIRE(datagrams.size() == samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    CAPTURE(i);
    CHECK(encoded(samples[i].envelope, samples[i].message) == datagrams[i]);
    const DecodedMessage decoded = decode_client_message(datagrams[i]);
    REQUIRE(decoded.refusal == ClientRefusal::none);
    CHECK(decoded.message.index() == samples[i].message.index());
    CHECK(decoded.header.type_code == datagrams[i][5]);
    CHECK(encoded(decoded.header.envelope, decoded.message) == datagrams[i]);
  }
}
