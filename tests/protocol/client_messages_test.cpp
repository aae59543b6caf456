#include "protocol/client_messages.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "tests/protocol/client_samples.hpp"
#include "tests/protocol/hex_bytes.hpp"

using namespace tissued::protocol;

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

ClientRefusal refusal_of(const Bytes& bytes) { return decode_client_message(bytes).refusal; }

// Sets the header's length to the datagram's.
Bytes with_true_length(Bytes bytes) {
  bytes[20] = static_cast<std::uint8_t>(bytes.size() & 0xFF);
  bytes[21] = static_cast<std::uint8_t>(bytes.size() >> 8);
  return bytes;
}

}  // namespace

TEST_CASE("the README's subscribe is what we send and read") {
  const Bytes golden = bytes_of_readme("subscribe");
  CHECK(encoded({0x1234abcd, 1, 0}, Subscribe{kTargets | kMesh, Precision::float32, 10, 50.0}) == golden);
  const DecodedMessage decoded = decode_client_message(golden);
  REQUIRE(decoded.refusal == ClientRefusal::none);
  CHECK(decoded.header.type == MessageType::subscribe);
  CHECK(decoded.header.envelope.session == 0x1234abcd);
  CHECK(decoded.header.envelope.sequence == 1);
  CHECK(decoded.header.envelope.in_reply_to == 0);
  const auto& message = std::get<Subscribe>(decoded.message);
  CHECK(message.what == (kTargets | kMesh));
  CHECK(message.precision == Precision::float32);
  CHECK(message.lease_s == 10);
  CHECK(message.rate_hz == 50.0);
}

TEST_CASE("the README's predictions are what we send and read") {
  const DecodedMessage decoded = decode_client_message(bytes_of_readme("predictions"));
  REQUIRE(decoded.refusal == ClientRefusal::none);
  CHECK(decoded.header.envelope.session == 0x51);
  CHECK(decoded.header.envelope.sequence == 42);
  const auto& message = std::get<Predictions>(decoded.message);
  CHECK(message.validity == Validity::valid);
  CHECK(message.tracker_frame == 1000);
  CHECK(message.has_stamp);
  CHECK(message.stamp_ns == 2'500'000'000);
  CHECK(message.receive_ns == 7'000'000'000);
  CHECK(message.send_ns == 7'002'500'000);
  CHECK(message.age_ns == 2'500'000);
  CHECK(message.step_time_ns == 1'800'000);
  CHECK(message.primal_residual == 0.001);
  CHECK(message.dual_residual == 0.002);
  CHECK(message.innovation_rms == 0.25);
  CHECK(message.iterations == 10);
  CHECK(message.markers_used == 19);
  CHECK(message.markers_seen == 19);
  REQUIRE(message.targets.size() == 1);
  CHECK(message.targets[0].position == std::array{1.5, -2.5, 30.0});
  CHECK(message.targets[0].covariance == std::array{0.04, 0.0, 0.0, 0.04, 0.0, 0.09});
  CHECK(message.targets[0].has_truth);
  CHECK(message.targets[0].truth == std::array{1.25, -2.5, 30.0});
  REQUIRE(message.pads.size() == 1);
  CHECK(message.pads[0].force == std::array{-0.75, 0.0, 0.0});
  CHECK(encoded(decoded.header.envelope, message) == bytes_of_readme("predictions"));
}

TEST_CASE("the fullest message of each kind fits one datagram") {
  const Name longest = Name::from("xxxxxxxxxxxxxxxxxxxxxxxx").value();
  Names names;
  names.total = 57;
  while (names.names.push_back(longest)) continue;
  Predictions predictions;
  while (predictions.targets.push_back({})) continue;
  while (predictions.pads.push_back({})) continue;
  Status status;
  while (status.counters.push_back({})) continue;
  ProbeView view;
  view.seen = view.has_image = true;
  view.size = {1, 1};
  view.spacing = {1.0, 1.0};
  while (view.targets.push_back({})) continue;
  std::vector<ClientMessage> fullest{names, predictions, status, view};
  for (const Precision precision : {Precision::float32, Precision::float64}) {
    MeshPositions positions;
    positions.precision = precision;
    positions.node_total = static_cast<std::uint32_t>(nodes_per_chunk(precision));
    positions.positions.resize(nodes_per_chunk(precision));
    fullest.push_back(positions);
  }
  for (const CellKind kind : {CellKind::tetrahedron, CellKind::skin_triangle}) {
    MeshCells cells;
    cells.kind = kind;
    cells.node_total = 1;
    cells.cell_total = static_cast<std::uint32_t>(cells_per_chunk(kind));
    cells.cells.resize(cells_per_chunk(kind));
    fullest.push_back(cells);
  }
  for (const ClientMessage& message : fullest) {
    const Bytes bytes = encoded({}, message);
    CAPTURE(message.index());
    CHECK(bytes.size() > 1000);
    const DecodedMessage decoded = decode_client_message(bytes);
    REQUIRE(decoded.refusal == ClientRefusal::none);
    CHECK(encoded({}, decoded.message) == bytes);
  }
}

TEST_CASE("nothing is encoded into too small a buffer, nor what is not finite") {
  for (const Sample& sample : client_samples()) {
    const Bytes whole = encoded(sample.envelope, sample.message);
    REQUIRE_FALSE(whole.empty());
    Bytes buffer(whole.size() - 1);
    const auto size =
        std::visit([&](const auto& m) { return encode_client_message(sample.envelope, m, buffer); }, sample.message);
    CHECK(size == 0);
  }
  const auto samples = client_samples();
  const auto refused = [](const auto& message) { return encoded({}, message).empty(); };
  HelloReply reply = std::get<HelloReply>(samples[8].message);
  reply.nominal_rate_hz = kNan;
  CHECK(refused(reply));
  CHECK(refused(Subscribe{kTargets, Precision::float32, 1, kNan}));
  Predictions predictions = std::get<Predictions>(samples[10].message);
  predictions.targets[1].covariance[5] = std::numeric_limits<double>::infinity();
  CHECK(refused(predictions));
  MeshPositions positions = std::get<MeshPositions>(samples[11].message);
  positions.positions[3][2] = 1e39;  // finite, but not as float32
  CHECK(refused(positions));
  positions.precision = Precision::float64;
  CHECK_FALSE(refused(positions));
  Status status = std::get<Status>(samples[15].message);
  status.step_rate_hz = kNan;
  CHECK(refused(status));
}

TEST_CASE("what is not known goes out as zero") {
  Predictions predictions;
  predictions.stamp_ns = 5;
  predictions.targets.push_back({0, {1, 2, 3}, {}, false, {kNan, 5, 6}});
  const DecodedMessage decoded = decode_client_message(encoded({}, predictions));
  REQUIRE(decoded.refusal == ClientRefusal::none);
  const auto& message = std::get<Predictions>(decoded.message);
  CHECK(message.stamp_ns == 0);
  CHECK(message.targets[0].truth == std::array{0.0, 0.0, 0.0});
}

TEST_CASE("every truncation of every message is refused as too short or of the wrong size") {
  for (const Sample& sample : client_samples()) {
    const Bytes whole = encoded(sample.envelope, sample.message);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      const ClientRefusal expected = size < 24 ? ClientRefusal::too_short : ClientRefusal::wrong_size;
      CHECK(refusal_of(part) == expected);
      if (size >= 24) CHECK(refusal_of(with_true_length(part)) == expected);
    }
  }
}

TEST_CASE("a message with bytes behind it is refused") {
  for (const Sample& sample : client_samples()) {
    Bytes longer = encoded(sample.envelope, sample.message);
    longer.push_back(0);
    CHECK(refusal_of(longer) == ClientRefusal::wrong_size);
    CHECK(refusal_of(with_true_length(longer)) == ClientRefusal::wrong_size);
    longer.resize(1401);
    CHECK(refusal_of(with_true_length(longer)) == ClientRefusal::too_long);
  }
}

TEST_CASE("every corrupted header byte of every message is refused by its name") {
  for (const Sample& sample : client_samples()) {
    const Bytes whole = encoded(sample.envelope, sample.message);
    for (std::size_t offset = 0; offset < 24; ++offset) {
      for (int value = 0; value < 256; ++value) {
        Bytes corrupted = whole;
        corrupted[offset] = static_cast<std::uint8_t>(value);
        if (corrupted == whole) continue;
        const ClientRefusal refusal = refusal_of(corrupted);
        if (offset < 4) {
          CHECK(refusal == ClientRefusal::bad_magic);
        } else if (offset == 4) {
          CHECK(refusal == ClientRefusal::bad_version);
        } else if (offset == 5) {
          const bool known = (value >= 0x01 && value <= 0x0A) || (value >= 0x81 && value <= 0x89) || value == 0xFF;
          CHECK((refusal == ClientRefusal::unknown_type) == !known);
        } else if (offset < 8) {
          CHECK(refusal == ClientRefusal::unknown_flags);
        } else if (offset < 20) {
          CHECK(refusal == ClientRefusal::none);
        } else {
          CHECK(refusal == ClientRefusal::wrong_size);
        }
      }
    }
  }
}

TEST_CASE("every corrupted body byte is refused, or read as exactly what it says") {
  for (const Sample& sample : client_samples()) {
    const Bytes whole = encoded(sample.envelope, sample.message);
    std::size_t unfaithful = 0;
    for (std::size_t offset = 24; offset < whole.size(); ++offset) {
      for (int value = 0; value < 256; ++value) {
        Bytes corrupted = whole;
        corrupted[offset] = static_cast<std::uint8_t>(value);
        const DecodedMessage decoded = decode_client_message(corrupted);
        if (decoded.refusal != ClientRefusal::none) continue;
        // Encoding refuses what is not finite, so this also tells that nothing such was accepted.
        const Bytes again = encoded(decoded.header.envelope, decoded.message);
        const bool lost_only_the_sign_of_zero = value == 0x80 && whole[offset] == 0x00 && again == whole;
        unfaithful += again == corrupted || lost_only_the_sign_of_zero ? 0 : 1;
      }
    }
    CAPTURE(sample.message.index());
    CHECK(unfaithful == 0);
  }
}

TEST_CASE("what failed to pass the gates after magic and version can still be answered") {
  Bytes bytes = bytes_of_readme("subscribe");
  bytes[5] = 0x33;
  const DecodedMessage decoded = decode_client_message(bytes);
  CHECK(decoded.refusal == ClientRefusal::unknown_type);
  CHECK(decoded.header.type_code == 0x33);
  CHECK(decoded.header.envelope.session == 0x1234abcd);
  CHECK(decoded.header.envelope.sequence == 1);
}

TEST_CASE("refusals, reasons and validities have distinct names") {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kClientRefusalCount; ++i) names.insert(to_string(static_cast<ClientRefusal>(i)));
  CHECK(names.size() == kClientRefusalCount);
  for (unsigned bit = 0; bit < kValidityReasonCount; ++bit) names.insert(validity_reason_name(bit));
  CHECK(names.size() == kClientRefusalCount + kValidityReasonCount);
  for (int i = 0; i < 4; ++i) names.insert(to_string(static_cast<Validity>(i)));
  for (int i = 1; i < 4; ++i) names.insert(to_string(static_cast<ErrorReason>(i)));
  CHECK(names.size() == kClientRefusalCount + kValidityReasonCount + 7);
  CHECK(names.count("unknown") == 0);
  CHECK(std::string(validity_reason_name(kValidityReasonCount)) == "unknown");
  CHECK(std::string(validity_reason_name(15)) == "unknown");
}
