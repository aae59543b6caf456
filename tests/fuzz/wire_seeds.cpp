// Writes the seeds of the datagram fuzzers: FOLDER/client_messages/*, FOLDER/tracker_stream/*, FOLDER/session_file/*
// FOLDER/sealed_datagram/* and FOLDER/sealed_ends/*.

#include <array>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "protocol/bytes.hpp"
#include "protocol/sealed_datagram.hpp"
#include "protocol/session_file.hpp"
#include "protocol/vicon_stream.hpp"
#include "tests/protocol/client_samples.hpp"

using namespace tissued::protocol;

namespace {

using Bytes = std::vector<std::uint8_t>;

void write(const std::filesystem::path& folder, std::size_t number, const Bytes& bytes) {
  std::filesystem::create_directories(folder);
  std::ofstream file(folder / std::to_string(number), std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// Four frames in as many datagrams as they need, 10 ms apart, as tracker_stream_fuzz.cpp reads them.
Bytes stream(int markers, bool stamps, std::uint32_t first_frame) {
  Bytes bytes;
  for (std::uint32_t k = 0; k < 4; ++k) {
    TrackerFrame frame;
    frame.frame_number = first_frame + k;
    if (stamps) frame.stamp_ns = 10'000'000ULL * k;
    frame.objects.push_back({Name::from("A1").value(), {1, 2, 3}, {0.1, 0.2, 0.3}});
    frame.forces.push_back({Name::from("A1").value(), {0.5, 0, 0}});
    frame.truth.push_back({Name::from("T1").value(), {4, 5, 6}});
    for (int i = 1; i <= markers; ++i) {
      const std::string label = (i < 10 ? "M0" : "M") + std::to_string(i);
      frame.markers.push_back({Name::from(label).value(), {7, 8, 9}, i % 5 == 0});
    }
    std::array<TrackerPacket, kMaxPacketsPerFrame> packets;
    const std::size_t count = encode_tracker_frame(frame, packets);
    for (std::size_t i = 0; i < count; ++i) {
      std::array<std::uint8_t, 4> prefix{};
      ByteWriter writer(prefix);
      writer.u16(i == 0 ? 10 : 0);
      writer.u16(static_cast<std::uint16_t>(packets[i].size));
      bytes.insert(bytes.end(), prefix.begin(), prefix.end());
      bytes.insert(bytes.end(), packets[i].view().begin(), packets[i].view().end());
    }
  }
  return bytes;
}

// A recording of a live session: the header, and a record of each kind.
Bytes session_file() {
  Bytes bytes(kSessionHeaderSize);
  SessionHeader header;
  header.scene = Name::from("demo").value();
  header.bundle = "/data/demo";
  write_session_header(header, bytes);
  AnswerSummary summary;
  summary.targets.push_back({1, 2, 3});
  Bytes answer(kMaxSessionBody);
  answer.resize(write_answer_summary(summary, answer));
  for (const auto& [kind, body] :
       {std::pair(SessionRecordKind::tracker_datagram, stream(2, true, 7)),
        std::pair(SessionRecordKind::client_datagram, Bytes{1, 2}), std::pair(SessionRecordKind::answer, answer),
        std::pair(SessionRecordKind::lost, Bytes(8, 1))}) {
    Bytes record(kSessionRecordOverhead + body.size());
    write_session_record({kind, 1'000'000'000, body}, record);
    bytes.insert(bytes.end(), record.begin(), record.end());
  }
  return bytes;
}

// Scripts as sealed_ends_fuzz.cpp reads them.
std::vector<Bytes> sealed_scripts() {
  const Bytes head{1, 1};  // the contact that is there at the beginning: its first question, and that it is not kept
  const Bytes exchange{1, 0, 4, 3, 0, 0, 0, 2, 0, 10, 4, 5, 0, 0, 0, 3, 0, 10, 4, 6, 0, 0, 1, 4, 5, 0, 0, 0};
  const Bytes change{5, 2, 0, 60, 0, 1, 1, 0, 0, 6, 80, 0, 'T', 'S', 'E', 'A', 1, 0, 0, 0};
  const Bytes forgery{7, 1, 0, 2, 0, 0x21, 9, 0, 0, 0, 0, 0, 0, 0, 4, 5, 0, 0, 0};
  Bytes crowd = head;  // more contacts than there are places, then what the first had sent
  for (int i = 0; i < 70; ++i) crowd.insert(crowd.end(), {0, 5, 1});
  crowd.insert(crowd.end(), {4, 2, 0, 0, 0});
  std::vector<Bytes> scripts{crowd};
  for (const Bytes& rest : {exchange, change, forgery}) {
    scripts.push_back(head);
    scripts.back().insert(scripts.back().end(), rest.begin(), rest.end());
  }
  return scripts;
}

// Of every kind, under the key of sealed_datagram_fuzz.cpp, but for sessions that nobody there has drawn.
std::vector<Bytes> sealed_datagrams() {
  std::array<std::uint8_t, kSecretKeySize> bytes{};
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  const SecretKey pre_shared(bytes);
  std::vector<Bytes> datagrams;
  for (const SealKind kind : {SealKind::data, SealKind::first_contact, SealKind::challenge}) {
    for (const SealDirection direction : {SealDirection::to_daemon, SealDirection::from_daemon}) {
      SealHeader header{kind, seal_key_id(pre_shared), {1}, {}, 1};
      if (kind != SealKind::first_contact) header.peer_session = {2};
      const Bytes payload(kind == SealKind::data ? 40 : 0, 7);
      Bytes out(kMaxSealed);
      out.resize(seal(seal_key(pre_shared, SealChannel::client, direction), header, payload, out));
      datagrams.push_back(out);
    }
  }
  return datagrams;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  std::size_t number = 0;
  for (const Sample& sample : client_samples()) {
    write(folder / "client_messages", number++, encoded(sample.envelope, sample.message));
  }
  number = 0;
  for (const std::uint32_t first_frame : {0U, 1000U, 0xFFFFFFFEU}) {
    write(folder / "tracker_stream", number++, stream(2, false, first_frame));
    write(folder / "tracker_stream", number++, stream(2, true, first_frame));
    write(folder / "tracker_stream", number++, stream(25, true, first_frame));
  }
  write(folder / "session_file", 0, session_file());
  number = 0;
  for (const Bytes& datagram : sealed_datagrams()) write(folder / "sealed_datagram", number++, datagram);
  number = 0;
  for (const Bytes& script : sealed_scripts()) write(folder / "sealed_ends", number++, script);
  return 0;
}
