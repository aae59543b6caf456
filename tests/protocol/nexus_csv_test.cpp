#include "protocol/nexus_csv.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "protocol/file_content.hpp"
#include "tests/protocol/hand_export.hpp"
#include "tests/protocol/text_edit.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued::protocol;
using namespace tissued::tests;
using Catch::Matchers::Contains;
using Vector = std::array<double, 3>;

namespace {

bool same(const Vector& a, const Vector& b) {
  for (int i = 0; i < 3; ++i) {
    if (a[i] != b[i] && !(std::isnan(a[i]) && std::isnan(b[i]))) return false;
  }
  return true;
}

bool same(const std::vector<Vector>& a, const std::vector<Vector>& b) {
  bool equal = a.size() == b.size();
  for (std::size_t i = 0; equal && i < a.size(); ++i) equal = same(a[i], b[i]);
  return equal;
}

void check_same(const Trial& a, const Trial& b) {
  CHECK(a.rate_hz == b.rate_hz);
  CHECK(a.first_frame == b.first_frame);
  CHECK(a.frame_count == b.frame_count);
  CHECK(a.labels == b.labels);
  CHECK(a.subjects == b.subjects);
  CHECK(same(a.positions, b.positions));
  CHECK(a.seen == b.seen);
  CHECK(a.devices == b.devices);
  CHECK(same(a.forces, b.forces));
}

struct Refusal {
  const char* from;
  const char* to;
  int line;
  const char* reason;
};

}  // namespace

TEST_CASE("a Nexus export is read as written by hand") {
  const Trial trial = parse_nexus_csv(kExport, "a.csv");
  CHECK(trial.rate_hz == 100.0);
  CHECK(trial.first_frame == 7);
  CHECK(trial.frame_count == 2);
  CHECK(trial.labels == std::vector<std::string>{"M01", "bare", "M01"});
  CHECK(trial.subjects == std::vector<std::string>{"phantom", "", "other"});
  CHECK(trial.position(0, 0) == Vector{-0.116, 0.029, 60.078});
  CHECK(trial.position(0, 1) == Vector{10, 20, 30});
  CHECK(trial.position(1, 2) == Vector{8, 8, 8});
  CHECK(trial.seen == std::vector<std::uint8_t>{1, 1, 1, 1, 0, 1});
  CHECK(std::isnan(trial.position(1, 1)[0]));
  CHECK(trial.devices == std::vector<std::string>{"A1", "A2"});
  CHECK(trial.force(0, 0) == Vector{1.5, -2, 0.3});
  CHECK(trial.force(0, 1) == Vector{-0.001, 0, 4});
  CHECK(trial.force(1, 0) == Vector{1.25, -2, 0.5});
  CHECK(std::isnan(trial.force(1, 1)[2]));

  CHECK(trial.find_label("bare") == 1);
  CHECK(trial.find_label("other:M01") == 2);
  CHECK(trial.find_label("M01") == 0);
  CHECK_FALSE(trial.find_label("M02"));
  CHECK_FALSE(trial.find_label("phantom:bare"));
  CHECK(trial.find_device("A2") == 1);
  CHECK_FALSE(trial.find_device("Plate"));
}

TEST_CASE("Windows line ends, a byte order mark and a spreadsheet's padding change nothing") {
  const Trial trial = parse_nexus_csv(kExport, "a.csv");
  check_same(parse_nexus_csv(with_crlf(kExport), "a.csv"), trial);
  check_same(parse_nexus_csv("\xEF\xBB\xBF" + kExport, "a.csv"), trial);
  check_same(parse_nexus_csv(kExport.substr(0, kExport.size() - 1), "a.csv"), trial);
  std::string padded;
  for (const char c : kExport) padded += c == '\n' ? std::string(", ,,\n") : std::string(1, c);
  check_same(parse_nexus_csv(padded, "a.csv"), trial);
}

TEST_CASE("trajectories alone make a trial") {
  const Trial trial = parse_nexus_csv(kExport.substr(kExport.find("Trajectories")), "a.csv");
  CHECK(trial.frame_count == 2);
  CHECK(trial.devices.empty());
  CHECK(trial.forces.empty());
}

TEST_CASE("devices that sample faster give the sample of the frame's instant") {
  const std::string trajectories =
      "Trajectories\n100\n,,M01,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n1,0,1,2,3\n2,0,4,5,6\n";
  const std::string head = "Devices\n300\n,,A1 - Force,,\nFrame,Sub Frame,Fx,Fy,Fz\n,,N,N,N\n";
  const std::string rows = "1,0,10,0,0\n1,1,11,0,0\n1,2,12,0,0\n2,0,20,0,0\n2,1,21,0,0\n2,2,22,0,0\n\n";
  // The blocks may stand in either order.
  for (const std::string& text : {head + rows + trajectories, trajectories + "\n" + head + rows}) {
    const Trial trial = parse_nexus_csv(text, "a.csv");
    CHECK(trial.rate_hz == 100.0);
    CHECK(trial.frame_count == 2);
    CHECK(trial.forces == std::vector<Vector>{{10, 0, 0}, {20, 0, 0}});
  }
  const std::string text = head + rows + trajectories;
  const std::vector<Refusal> refusals{
      {"300\n", "200\n", 11, "do not go with"},
      {"300\n", "250\n", 11, "do not go with"},
      {"2,2,22,0,0\n", "", 11, "frame 2 has 2 sub frames, the first one has 3"},
      {"1,2,12,0,0\n", "", 11, "frame 2 has 3 sub frames, the first one has 2"},
      {"1,1,11,0,0\n", "", 7, "Sub Frame must be 1 of frame 1"},
      {"2,2,22,0,0\n", "2,3,22,0,0\n", 11, "Sub Frame must be 2 of frame 2"},
  };
  for (const Refusal& refusal : refusals) {
    INFO("'" << refusal.from << "' -> '" << refusal.to << "'");
    try {
      parse_nexus_csv(edited(text, refusal.from, refusal.to), "a.csv");
      FAIL_CHECK("accepted");
    } catch (const TrialError& error) {
      CHECK(error.line() == refusal.line);
      CHECK_THAT(error.reason(), Contains(refusal.reason));
    }
  }
}

TEST_CASE("a bad export is refused at its line and column") {
  const std::vector<Refusal> refusals{
      {"Devices\n", "Devices,1\n", 1, "the title of a block"},
      {"Devices\n", "12\n", 1, "the title of a block"},
      {"Joints", "Devices", 9, "a second block 'Devices'"},
      {"Trajectories", "Joints", 0, "no block Trajectories"},
      {"Devices\n100\n", "Devices\nfast\n", 2, "the rate"},
      {"Devices\n100\n", "Devices\n0\n", 2, "the rate"},
      {"Devices\n100\n", "Devices\n-100\n", 2, "the rate"},
      {"Devices\n100\n", "Devices\nnan\n", 2, "the rate"},
      {"Devices\n100\n", "Devices\n100,100\n", 2, "the rate"},
      {"Devices\n100\n", "Devices\n50\n", 7, "do not go with"},
      {",,A2 - Force,,\n", ",,A2 - Force,,,A3 - Force\n", 3, "column 12: 'A3 - Force' stands over no components"},
      {",,A1 - Force,,,", ",A0 - Force,A1 - Force,,,", 3, "column 2: 'A0 - Force' stands over no components"},
      {",,A1 - Force,,,", ",,,,,", 3, "column 3: a name is missing"},
      {"Frame,Sub Frame,Fx", "Frame,Fx", 4, "must start with Frame,Sub Frame"},
      {"Frame,Sub Frame,Fx,Fy,Fz,Cx", "Frame,Sub Frame,Fx,Fz,Fy,Cx", 4, "column 3: 'A1 - Force' must have"},
      {"N,N,N,mm", "N,N,lbf,mm", 5, "column 5: the unit must be N, not 'lbf'"},
      {"7,0,1.5", "7.5,0,1.5", 6, "column 1: Frame: '7.5' is not an integer"},
      {"7,0,1.5", "-7,0,1.5", 6, "column 1: Frame is out of range"},
      {"7,0,1.5", "7,1,1.5", 6, "column 2: the first Sub Frame must be 0"},
      {"7,0,1.5", "7,0,1.5e", 6, "column 3: A1 - Force Fx: '1.5e' is not a finite number"},
      {"8,0,1.25,-2,0.5", "8,0,1.25,,0.5", 7, "column 3: A1 - Force: some of its three cells are empty"},
      {"8,0,1.25", "9,0,1.25", 7, "column 1: Frame must be 8"},
      {"8,0,1.25", "8,0,,1.25", 7, "column 3: A1 - Force: some of its three cells are empty"},
      {"-0.001,0,4\n", "-0.001,0,4,5\n", 6, "12 cells where the header has 11"},
      {"phantom:M01,,,bare", "phantom:M01,,,phantom:M01", 0, "two trajectories are called 'phantom:M01'"},
      {"other:M01", "other:", 0, "without a label"},
      {",,phantom:M01,,,bare,,,", ",,phantom:M01,,,,,,", 16, "column 3: 'phantom:M01' must have"},
      {",,phantom:M01,,,bare,,,", ",,phantom:M01,,bare,,,,", 16, "column 3: 'phantom:M01' must have"},
      {"cm,cm,cm", "cm,mm,cm", 17, "column 7: another unit"},
      {"cm,cm,cm", "in,in,in", 17, "column 6: the unit must be mm, cm or m, not 'in'"},
      {"cm,cm,cm,mm,mm,mm", "cm,cm,cm", 17, "column 9: the unit must be mm, cm or m, not ''"},
      {"60.078", "6O.078", 18, "column 5: phantom:M01 Z: '6O.078' is not a finite number"},
      {"60.078", "inf", 18, "column 5: phantom:M01 Z: 'inf' is not a finite number"},
      {"1,2,3,9,9,9", "1e308,2,3,9,9,9", 18, "column 6: bare X"},
      {"7,0,-0.116", "9999999999,0,-0.116", 18, "column 1: Frame is out of range"},
      {"8,0,-0.112", "8,1,-0.112", 19, "Sub Frame must be 1 of frame 7"},
      {"8,0,-0.112,", "8,0,", 19, "10 cells where the header has 11"},
      {"7,0,-0.116", "6,0,-0.116", 19, "column 1: Frame must be 7"},
      {"8,0,-0.112,-0.034,59.884,,,,8,8,8\n", "", 18, "devices hold frames 7 to 8, trajectories 7 to 7"},
      {"8,0,1.25,-2,0.5,,,,,,\n", "", 6, "devices hold frames 7 to 7, trajectories 7 to 8"},
  };
  for (const Refusal& refusal : refusals) {
    INFO("'" << refusal.from << "' -> '" << refusal.to << "'");
    try {
      parse_nexus_csv(edited(kExport, refusal.from, refusal.to), "a.csv");
      FAIL_CHECK("accepted");
    } catch (const TrialError& error) {
      CHECK(error.line() == refusal.line);
      CHECK_THAT(error.reason(), Contains(refusal.reason));
    }
  }
}

TEST_CASE("every truncation of an export is refused, but where a number may be shorter") {
  // With devices, even a cut between two rows shows.
  const std::size_t last_cell = kExport.rfind(',') + 1;
  for (std::size_t length = 0; length < kExport.size(); ++length) {
    INFO("cut at " << length);
    const std::string cut = kExport.substr(0, length);
    if (length <= last_cell) {
      CHECK_THROWS_AS(parse_nexus_csv(cut, "a.csv"), TrialError);
    } else {
      CHECK(parse_nexus_csv(cut, "a.csv").frame_count == 2);
    }
  }
}

TEST_CASE("any byte of an export may be wrong") {
  for (std::size_t at = 0; at < kExport.size(); ++at) {
    for (const char byte : {'\0', '\n', ',', '-', '9', '\xFF'}) {
      std::string corrupt = kExport;
      corrupt[at] = byte;
      try {
        const Trial trial = parse_nexus_csv(corrupt, "a.csv");
        CHECK(trial.positions.size() == trial.frame_count * trial.labels.size());
        CHECK(trial.seen.size() == trial.positions.size());
        CHECK(trial.forces.size() == trial.frame_count * trial.devices.size());
      } catch (const TrialError& error) {
        CHECK(error.line() <= 20);
      }
    }
  }
}

TEST_CASE("what is written as an export reads back to the same bits") {
  Trial trial = parse_nexus_csv(kExport, "a.csv");
  trial.positions[0] = {1.0 / 3.0, -1e-17, 12345.678901234567};
  trial.forces[0] = {0.1 + 0.2, -0.0, 1e300};
  check_same(parse_nexus_csv(format_nexus_csv(trial), "a.csv"), trial);

  const TemporaryFolder folder;
  write_nexus_csv(trial, folder.path() / "b.csv");
  const Trial read = read_nexus_csv(folder.path() / "b.csv");
  check_same(read, trial);
  CHECK(read.file == (folder.path() / "b.csv").string());
  CHECK_THROWS_AS(write_nexus_csv(trial, folder.path() / "none" / "b.csv"), FileError);
  CHECK_THROWS_AS(read_nexus_csv(folder.path() / "c.csv"), FileError);
}

TEST_CASE("a name that a cell cannot hold is not written") {
  for (const char* name : {"", "M,1", "M\n1", " M1"}) {
    Trial trial = parse_nexus_csv(kExport, "a.csv");
    trial.labels[1] = name;
    CHECK_THROWS_AS(format_nexus_csv(trial), std::invalid_argument);
  }
}

TEST_CASE("the recordings of table1 are read whole") {
  const std::filesystem::path folder = std::filesystem::path(TISSUED_SHARED_DATA) / "recordings/paper/table1";
  if (!std::filesystem::exists(folder)) {
    WARN("no shared data at " << folder << ", skipped");
    return;
  }
  // Experiments 1 to 4 push A1, then A2, then both, then A3 and A4.
  const std::vector<std::vector<std::string>> pads{{"A1"}, {"A2"}, {"A1", "A2"}, {"A3", "A4"}};
  for (int experiment = 1; experiment <= 16; ++experiment) {
    const std::string number = (experiment < 10 ? "0" : "") + std::to_string(experiment);
    const Trial trial = read_nexus_csv(folder / std::string("exp").append(number).append(".csv"));
    INFO(trial.file);
    CHECK(trial.rate_hz == 100.0);
    CHECK(trial.frame_count == 401);
    std::vector<std::string> labels;
    for (int i = 1; i <= 19; ++i) labels.push_back(std::string(i < 10 ? "M0" : "M").append(std::to_string(i)));
    for (int i = 1; i <= 4; ++i) labels.push_back(std::string("T").append(std::to_string(i)));
    const auto& pushed = pads[(experiment - 1) / 4];
    labels.insert(labels.end(), pushed.begin(), pushed.end());
    CHECK(trial.labels == labels);
    CHECK(trial.subjects == std::vector<std::string>(labels.size(), "phantom"));
    CHECK(trial.devices == pushed);
    CHECK(std::count(trial.seen.begin(), trial.seen.end(), 1) == static_cast<std::ptrdiff_t>(trial.seen.size()));
  }
}

TEST_CASE("every number of a recording is where a plain reading of the file finds it") {
  const std::filesystem::path path = std::filesystem::path(TISSUED_SHARED_DATA) / "recordings/paper/table1/exp09.csv";
  std::ifstream file(path);
  if (!file) {
    WARN("no shared data at " << path << ", skipped");
    return;
  }
  const Trial trial = read_nexus_csv(path);
  std::vector<double> expected;
  bool trajectories = false;
  for (std::string line; std::getline(file, line);) {
    trajectories |= line == "Trajectories";
    // Of all lines, the rows alone start with a digit and hold commas.
    if (!trajectories || line.find(',') == std::string::npos || std::isdigit(line[0]) == 0) continue;
    const char* at = line.c_str();
    for (int cell = 0; *at != '\0'; ++cell) {
      char* end = nullptr;
      const double value = std::strtod(at, &end);
      if (cell >= 2) expected.push_back(value);
      at = *end == ',' ? end + 1 : end;
    }
  }
  REQUIRE(expected.size() == 3 * trial.positions.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) different += trial.positions[i / 3][i % 3] != expected[i];
  CHECK(different == 0);
}
