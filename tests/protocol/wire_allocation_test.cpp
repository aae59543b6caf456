// Counts what the heap is asked for while datagrams are read, joined and written.

#include <catch2/catch.hpp>
#include <vector>

#include "protocol/address_cookie.hpp"
#include "protocol/frame_assembler.hpp"
#include "protocol/sealed_contact.hpp"
#include "protocol/sealed_sessions.hpp"
#include "protocol/sequence_gate.hpp"
#include "tests/allocation_count.hpp"
#include "tests/protocol/client_samples.hpp"

using namespace tissued::protocol;

TEST_CASE("the tracker's way in and out asks nothing of the heap") {
  FrameAssembler assembler({.markers = {Name::from("M0").value()}});
  TrackerFrame frame;
  frame.stamp_ns = 1;
  for (const char* name : {"A1", "A2", "M0"}) frame.objects.push_back({Name::from(name).value(), {1, 2, 3}, {}});
  for (const char* name : {"M1", "M2", "M3"}) frame.markers.push_back({Name::from(name).value(), {1, 2, 3}, false});
  std::vector<TrackerPacket> packets(kMaxPacketsPerFrame);
  TrackerDatagram datagram;
  std::size_t emitted = 0;
  const std::size_t before = allocation_count();
  for (std::uint32_t number = 0; number < 100; ++number) {
    frame.frame_number = number;
    const std::size_t count = encode_tracker_frame(frame, packets);
    for (std::size_t i = 0; i < count; ++i) {
      if (decode_tracker_datagram(packets[i].view(), datagram) != TrackerRefusal::none) continue;
      emitted += assembler.add(datagram, number * 10'000'000ULL).size();
      emitted += assembler.flush_if_due(number * 10'000'000ULL).size();
    }
  }
  CHECK(allocation_count() == before);
  CHECK(emitted == 100);
}

TEST_CASE("client messages ask nothing of the heap") {
  const auto samples = client_samples();
  std::vector<std::uint8_t> buffer(kMaxDatagram);
  SequenceGate gate;
  std::size_t read = 0;
  const std::size_t before = allocation_count();
  for (const Sample& sample : samples) {
    const std::size_t size =
        std::visit([&](const auto& m) { return encode_client_message(sample.envelope, m, buffer); }, sample.message);
    const DecodedMessage decoded = decode_client_message(std::span(buffer).first(size));
    gate.judge(decoded.header.envelope);
    read += decoded.refusal == ClientRefusal::none ? 1 : 0;
  }
  CHECK(allocation_count() == before);
  CHECK(read == samples.size());
}

TEST_CASE("sealed datagrams and cookies ask nothing of the heap") {
  const SecretKey key = SecretKey::random();
  const std::vector<SealedSessions::Key> keys{{key}};
  SealedSessions daemon(SealChannel::client, keys);
  SealedContact client(SealChannel::client, key);
  const AddressCookie cookies;
  std::vector<std::uint8_t> payload(kMaxDatagram), up(kMaxSealed), down(kMaxSealed);
  std::size_t taken = 0;
  const std::size_t before = allocation_count();
  for (std::uint16_t port = 0; port < 200; ++port) {  // each from elsewhere: a new contact, in the end another's place
    const SourceAddress from{{}, port};
    for (int i = 0; i < 4; ++i) {
      const bool known = client.established();
      const std::size_t size = known ? client.seal(payload, up) : client.seal_first_contact(up);
      const auto opened = daemon.open(std::span(up).first(size), from);
      if (!opened.challenge.empty()) client.open(opened.challenge);
      if (opened.payload.empty()) continue;
      const std::size_t answered = daemon.seal(opened.contact, opened.payload, down);
      taken += client.open(std::span(down).first(answered)).payload.size() == kMaxDatagram ? 1 : 0;
    }
    taken += cookies.is_good(cookies.make(from, port), from, port) ? 1 : 0;
  }
  CHECK(allocation_count() == before);
  CHECK(daemon.evicted() > 100);
  CHECK(taken > 400);
}
