#include "protocol/c3d.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "protocol/file_content.hpp"
#include "tests/protocol/c3d_bytes.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;
using Catch::Matchers::Contains;
using Vector = std::array<double, 3>;

namespace {

Trial parse(const std::string& content) { return parse_c3d(as_bytes(content), "a.c3d"); }

void check_small_file(const Trial& trial) {
  CHECK(trial.rate_hz == 100.0);
  CHECK(trial.first_frame == 11);
  CHECK(trial.frame_count == 3);
  CHECK(trial.labels == std::vector<std::string>{"one", "two"});
  CHECK(trial.subjects == std::vector<std::string>{"body", ""});
  CHECK(trial.seen == std::vector<std::uint8_t>{1, 1, 1, 0, 1, 1});
  REQUIRE(trial.positions.size() == 6);
  CHECK(trial.position(0, 0) == Vector{1, -2.5, 0.03125});
  CHECK(trial.position(2, 0) == Vector{3, -2.5, 0.03125});
  CHECK(trial.position(2, 1) == Vector{7, 8, 11});
  CHECK(std::isnan(trial.position(1, 1)[0]));
  CHECK(trial.devices.empty());
}

// One frame of one point per label; coordinates name the point.
C3dFile labelled_file(int points) {
  C3dFile file;
  file.points = points;
  for (int i = 0; i < points; ++i) file.point(static_cast<float>(i), 0.0F, 0.0F, 0.0F);
  return file;
}

struct Refusal {
  const char* what;
  C3dFile file;
  const char* reason;
};

}  // namespace

TEST_CASE("float points of every machine") {
  for (const Machine machine : {Machine::intel, Machine::dec, Machine::mips}) {
    INFO("machine " << static_cast<int>(machine));
    check_small_file(parse(small_c3d_file(machine).content()));
  }
}

TEST_CASE("a VAX number by its bytes") {
  // From the VAX architecture: 1.0 is 80 40 00 00, -0.1 is CC BE CD CC.
  C3dFile file(Machine::dec);
  file.points = 1;
  file.usual_parameters({"one"});
  std::string content = file.content();
  content += std::string("\x80\x40\x00\x00\xCC\xBE\xCD\xCC\x00\x00\x00\x00\x00\x00\x00\x00", 16);
  const Trial trial = parse(content);
  CHECK(trial.position(0, 0)[0] == 1.0);
  CHECK(trial.position(0, 0)[1] == static_cast<double>(-0.1F));
  CHECK(trial.position(0, 0)[2] == 0.0);
  // A sign without a number is the VAX's reserved operand, its NaN.
  content[content.size() - 15] = '\x80';
  content[content.size() - 16] = '\x00';
  CHECK_FALSE(parse(content).is_seen(0, 0));
}

TEST_CASE("scaled integer points of every machine") {
  for (const Machine machine : {Machine::intel, Machine::dec, Machine::mips}) {
    INFO("machine " << static_cast<int>(machine));
    C3dFile file(machine);
    file.points = 2;
    file.analog_per_frame = 3;
    file.last_frame = 2;
    file.scale = 0.5F;
    file.usual_parameters({"one", "two"}, "cm");
    for (int frame = 0; frame < 2; ++frame) {
      file.integer_point(300, -301, 32767 - frame, 0x7F07);
      file.integer_point(1, 2, 3, frame == 0 ? -1 : 0x0107);
      for (int i = 0; i < 3; ++i) file.integer_analog(-1);
    }
    const Trial trial = parse(file.content());
    CHECK(trial.frame_count == 2);
    CHECK(trial.position(0, 0) == Vector{1500, -1505, 163835});
    CHECK(trial.position(1, 0) == Vector{1500, -1505, 163830});
    CHECK(trial.position(1, 1) == Vector{5, 10, 15});
    CHECK(trial.seen == std::vector<std::uint8_t>{1, 0, 1, 1});
  }
}

TEST_CASE("lengths come out in mm") {
  for (const auto& [unit, factor] : {std::pair{"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}, {"", 1.0}}) {
    C3dFile file;
    file.points = 1;
    file.usual_parameters({"one"}, unit);
    file.point(0.25F, -0.5F, 2.0F, 0.0F);
    CHECK(parse(file.content()).position(0, 0) == Vector{0.25 * factor, -0.5 * factor, 2.0 * factor});
  }
}

TEST_CASE("a point that is not finite is a gap") {
  C3dFile file;
  file.points = 3;
  file.usual_parameters({"one", "two", "three"});
  file.point(NAN, 0, 0, 0);
  file.point(0, 0, INFINITY, 0);
  file.point(0, 0, 0, NAN);
  CHECK(parse(file.content()).seen == std::vector<std::uint8_t>{0, 0, 0});
}

TEST_CASE("parameters come in any order, in any case, with empty arrays and locked names") {
  C3dFile file;
  file.points = 1;
  file.scale = -0.1F;
  file.rate = 0.0F;  // wrong in the header, right in the parameters
  file.text(9, "Cropped Measurement Frame", 4, {});
  file.parameter(9, "NOTHING", 2, {0}, "");
  file.parameter(9, "BOX", 4, {2, 0, 3}, "");
  file.parameter(3, "Rate", 4, {}, std::string("\x00\x00\x48\x43", 4));  // 200
  file.text(3, "LABELS", 32, {" Tip - 1 "});
  file.text(9, "LABELS", 4, {"no"});
  file.words(8, "USED", {77}, true);
  file.group(9, "Other Group");
  file.group(8, "ANALOG");
  file.group(3, "point");
  file.point(1, 2, 3, 0);
  const Trial trial = parse(file.content());
  CHECK(trial.rate_hz == 200.0);
  CHECK(trial.labels == std::vector<std::string>{"Tip - 1"});
  CHECK(trial.position(0, 0) == Vector{1, 2, 3});
}

TEST_CASE("labels beyond 255 stand in LABELS2 and on, points without one are numbered") {
  C3dFile file = labelled_file(600);
  file.parameter_blocks = 12;
  std::vector<std::vector<std::string>> labels(3);
  for (int i = 0; i < 590; ++i) labels[i / 255].push_back(std::string("L").append(std::to_string(i)));
  file.group(1, "POINT");
  file.text(1, "LABELS3", 8, labels[2]);
  file.text(1, "LABELS", 8, labels[0]);
  file.text(1, "LABELS2", 8, labels[1]);
  const Trial trial = parse(file.content());
  REQUIRE(trial.labels.size() == 600);
  for (const int i : {0, 254, 255, 509, 510, 589}) {
    CHECK(trial.labels[i] == "L" + std::to_string(i));
    CHECK(trial.position(0, i)[0] == i);
  }
  CHECK(trial.labels[590] == "point 591");
  CHECK(trial.labels[599] == "point 600");
}

TEST_CASE("labels beyond the points are left out") {
  C3dFile file = labelled_file(1);
  file.usual_parameters({"one", "two"});
  CHECK(parse(file.content()).labels == std::vector<std::string>{"one"});
}

TEST_CASE("takes above 65535 frames") {
  constexpr int kFrames = 70000;
  for (const bool by_trial_group : {true, false}) {
    C3dFile file;
    file.points = 1;
    file.last_frame = 65535;
    file.usual_parameters({"one"});
    if (by_trial_group) {
      file.words(2, "ACTUAL_START_FIELD", {1, 0});
      file.words(2, "ACTUAL_END_FIELD", {kFrames & 0xFFFF, kFrames >> 16});
      file.group(2, "TRIAL");
    } else {
      file.real(1, "LONG_FRAMES", kFrames);
    }
    for (int i = 0; i < kFrames; ++i) file.point(static_cast<float>(i), 0, 0, 0);
    const Trial trial = parse(file.content());
    CHECK(trial.frame_count == kFrames);
    CHECK(trial.position(kFrames - 1, 0)[0] == kFrames - 1);
  }
}

TEST_CASE("a bad C3D file is refused with its reason") {
  const auto with = [](auto change) {
    C3dFile file = small_c3d_file(Machine::intel);
    change(file);
    return file;
  };
  const auto bare = [](auto change) {
    C3dFile file;
    file.points = 1;
    change(file);
    file.point(0, 0, 0, 0);
    return file;
  };
  const std::vector<Refusal> refusals{
      {"points", with([](C3dFile& f) { f.points = 3; }), "byte 2: the header says 3 points, POINT:USED does not"},
      {"no points", bare([](C3dFile& f) { f.points = 0; }), "byte 2: no points"},
      {"cut", with([](C3dFile& f) { f.last_frame = 14; }),
       "byte 1024: 4 frames of 52 bytes should start here, the "
       "file holds 3"},
      {"analog", with([](C3dFile& f) { f.analog_per_frame = 6; }), "3 frames of 56 bytes"},
      {"frames", with([](C3dFile& f) { f.last_frame = 9; }), "byte 6: frames 11 to 9 are none"},
      {"scale", bare([](C3dFile& f) { f.scale = 0.0F; }), "byte 12: the scale"},
      {"scale", bare([](C3dFile& f) { f.scale = NAN; }), "byte 12: the scale"},
      {"rate", bare([](C3dFile& f) { f.rate = 0.0F; }), "byte 20: the frame rate"},
      {"rate", bare([](C3dFile& f) { f.rate = INFINITY; }), "byte 20: the frame rate"},
      {"unit", bare([](C3dFile& f) { f.usual_parameters({"one"}, "ft"); }), "mm, cm or m, not 'ft'"},
      {"machine", C3dFile(static_cast<Machine>(83)), "byte 515: processor 83 is none of"},
      {"type", bare([](C3dFile& f) { f.parameter(1, "X", 3, {}, "123"); }), "unknown type 3"},
      {"size", bare([](C3dFile& f) {
         f.parameter(1, "X", 4, {255, 255, 255, 255, 255, 255}, "");
       }),
       "larger than"},
      {"size", bare([](C3dFile& f) { f.parameter(1, "X", 4, {250}, ""); }), "the file is cut off"},
  };
  for (const Refusal& refusal : refusals) {
    INFO(refusal.what << ": " << refusal.reason);
    CHECK_THROWS_WITH(parse(refusal.file.content()), Contains(refusal.reason));
    CHECK_THROWS_AS(parse(refusal.file.content()), TrialError);
  }
  C3dFile twins = labelled_file(2);
  twins.usual_parameters({"one", "one"});
  CHECK_THROWS_WITH(parse(twins.content()), "a.c3d: two points are called 'one'");

  std::string other = small_c3d_file(Machine::intel).content();
  other[1] = 'P' + 1;
  CHECK_THROWS_WITH(parse(other), Contains("byte 1: not a C3D file"));
  other = small_c3d_file(Machine::intel).content();
  other[0] = 1;
  CHECK_THROWS_WITH(parse(other), Contains("byte 0: the parameters cannot start in block 1"));
  other = small_c3d_file(Machine::intel).content();
  other[16] = 1;
  CHECK_THROWS_WITH(parse(other), Contains("byte 16: the data cannot start in block 1"));
}

TEST_CASE("every truncation of a C3D file is refused") {
  const std::string content = small_c3d_file(Machine::intel).content();
  for (std::size_t length = 0; length < content.size(); ++length) {
    CHECK_THROWS_AS(parse(content.substr(0, length)), TrialError);
  }
}

TEST_CASE("any byte of a C3D file may be wrong") {
  const std::string content = small_c3d_file(Machine::intel).content();
  for (std::size_t at = 0; at < content.size(); ++at) {
    for (const int byte : {0x00, 0x01, 0x7F, 0x80, 0xFF, 0x54, 0x56}) {
      std::string corrupt = content;
      corrupt[at] = static_cast<char>(byte);
      try {
        const Trial trial = parse(corrupt);
        CHECK(trial.positions.size() == trial.frame_count * trial.labels.size());
        for (std::size_t i = 0; i < trial.positions.size(); ++i) {
          CHECK(std::isfinite(trial.positions[i][0]) == (trial.seen[i] != 0));
        }
      } catch (const TrialError& error) {
        CHECK(error.file() == "a.c3d");
      }
    }
  }
}

TEST_CASE("what is written as C3D reads back, rounded to float") {
  Trial trial = parse(small_c3d_file(Machine::intel).content());
  trial.positions[0] = {1.0 / 3.0, -1e-17, 12345.678901234567};
  const TemporaryFolder folder;
  write_c3d(trial, folder.path() / "b.c3d");
  const Trial read = read_c3d(folder.path() / "b.c3d");
  CHECK(read.rate_hz == trial.rate_hz);
  CHECK(read.first_frame == trial.first_frame);
  CHECK(read.frame_count == trial.frame_count);
  CHECK(read.labels == trial.labels);
  CHECK(read.subjects == trial.subjects);
  CHECK(read.seen == trial.seen);
  for (std::size_t i = 0; i < trial.positions.size(); ++i) {
    for (int axis = 0; axis < 3 && trial.seen[i] != 0; ++axis) {
      CHECK(read.positions[i][axis] == static_cast<float>(trial.positions[i][axis]));
    }
  }
  CHECK(std::filesystem::file_size(folder.path() / "b.c3d") % 512 == 0);
  CHECK_THROWS_AS(read_c3d(folder.path() / "c.c3d"), FileError);
}

TEST_CASE("many points and many frames survive writing") {
  Trial trial;
  trial.rate_hz = 250.0;
  trial.first_frame = 60000;
  trial.frame_count = 300;
  for (int i = 0; i < 700; ++i) trial.add_label(std::string("somebody:marker ").append(std::to_string(i)));
  for (std::size_t i = 0; i < trial.frame_count * trial.labels.size(); ++i) {
    trial.positions.push_back({static_cast<double>(i), 0.5, -1.0});
    trial.seen.push_back(1);
  }
  const Trial wide = parse(format_c3d(trial));
  CHECK(wide.labels == trial.labels);
  CHECK(wide.subjects == trial.subjects);
  CHECK(wide.positions == trial.positions);
  CHECK(wide.first_frame == 60000);

  trial.labels.resize(3);
  trial.subjects.resize(3);
  trial.frame_count = 70000;
  const Trial tall = parse(format_c3d(trial));
  CHECK(tall.frame_count == 70000);
  CHECK(tall.first_frame == 60000);
  CHECK(tall.positions == trial.positions);
}

TEST_CASE("what C3D cannot hold is not written") {
  const Trial good = parse(small_c3d_file(Machine::intel).content());
  Trial trial = good;
  trial.labels[0] = std::string(128, 'x');
  CHECK_THROWS_AS(format_c3d(trial), std::invalid_argument);
  trial = good;
  trial.labels[1] = "";
  CHECK_THROWS_AS(format_c3d(trial), std::invalid_argument);
  trial = good;
  trial.frame_count = 0;
  CHECK_THROWS_AS(format_c3d(trial), std::invalid_argument);
  CHECK_THROWS_AS(format_c3d(Trial{}), std::invalid_argument);
  trial = good;
  trial.labels.assign(1200, std::string(127, 'x'));
  trial.subjects.assign(1200, "");
  CHECK_THROWS_WITH(format_c3d(trial), Contains("do not fit the parameters"));
}

TEST_CASE("the real beam moves as its README says") {
  const std::filesystem::path folder = std::filesystem::path(TISSUED_SHARED_DATA) / "real/beam";
  if (!std::filesystem::exists(folder)) {
    WARN("no shared data at " << folder << ", skipped");
    return;
  }
  struct Take {
    const char* file;
    std::size_t frames;
    std::size_t held_until;
    double trough;
    double end;
  };
  // Displacement of Tip - 2 upwards in mm; up is the tracker's x by bundle.json's world_from_tracker.
  for (const Take& take : {Take{"gravity.c3d", 500, 66, -10.65, -6.59}, Take{"load52.c3d", 600, 45, -24.98, -17.32}}) {
    INFO(take.file);
    const Trial trial = read_c3d(folder / take.file);
    CHECK(trial.rate_hz == 100.0);
    CHECK(trial.first_frame == 1);
    CHECK(trial.frame_count == take.frames);
    CHECK(trial.labels ==
          std::vector<std::string>{"Tip - 1", "Tip - 2", "Tip - 3", "Base - 1", "Base - 2", "Base - 3"});
    CHECK(std::count(trial.seen.begin(), trial.seen.end(), 0) == 0);
    const std::size_t tip = *trial.find_label("Tip - 2");
    // At rest from frame 21, where the tracker's start-up ends, until it is let go.
    double rest = 0.0;
    for (std::size_t f = 21; f < take.held_until; ++f) {
      rest += trial.position(f, tip)[0] / static_cast<double>(take.held_until - 21);
    }
    double trough = 0.0;
    for (std::size_t f = take.held_until; f < take.held_until + 30; ++f) {
      trough = std::min(trough, trial.position(f, tip)[0] - rest);
    }
    CHECK(trough == Approx(take.trough).margin(0.02));
    CHECK(trial.position(take.frames - 1, tip)[0] - rest == Approx(take.end).margin(0.02));
  }
}
