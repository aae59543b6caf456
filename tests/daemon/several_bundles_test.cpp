// Several bundles at once: over the processors of one machine, and over the ranks that mpirun starts.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/daemon/evaluation_bundle.hpp"
#include "tests/temporary_folder.hpp"

namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

struct Outcome {
  int code = -1;
  std::string out, err;
};

// `tissuectl diagnose` of three bundles, the second of which is none, with reports in `folder`/`results`.
Outcome diagnose_three(const TemporaryFolder& folder, const std::string& launcher, const std::string& results) {
  for (const char* name : {"first", "third"}) {
    const TemporaryFolder bundle;
    write_evaluation_bundle(bundle, name);
    fs::copy(bundle.path(), folder.path() / name, fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  }
  fs::create_directories(folder.path() / "broken");
  const std::string at = folder.path().string() + "/";
  const std::string command = launcher + TISSUECTL_PROGRAM + " diagnose " + at + "first " + at + "broken/ " + at +
                              "third --quick --budget 1000 --out " + at + results + " >" + at + "out 2>" + at + "err";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(at + "out"), content(at + "err")};
}

// All that does not depend on the clock.
nlohmann::json report(const TemporaryFolder& folder, const std::string& results, const std::string& bundle) {
  nlohmann::json json = nlohmann::json::parse(content(folder.path() / results / bundle / "report.json"));
  json.erase("seconds");
  return json;
}

std::size_t lines_of(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

void check_three(const Outcome& outcome) {
  CHECK(outcome.code == 1);
  // A heading, a row for each, and what was wrong with the broken one.
  CHECK(lines_of(outcome.out) == 5);
  CHECK_THAT(outcome.out, Catch::Contains("broken  ") && Catch::Contains("failed"));
  CHECK_THAT(outcome.out, Catch::Contains("broken/bundle.json: no such file"));
  for (const char* line : {"1 of 3: ", "2 of 3: ", "3 of 3: ", ": broken: failed: "})
    CHECK_THAT(outcome.err, Catch::Contains(line));
}

}  // namespace

TEST_CASE("A bundle that fails is named, and does not stop the others") {
  const TemporaryFolder folder;
  const Outcome outcome = diagnose_three(folder, "", "alone");
  check_three(outcome);
  CHECK(lines_of(outcome.err) == 3);
  CHECK(report(folder, "alone", "first")["bundle"] == "first");
  CHECK(report(folder, "alone", "third")["bundle"] == "third");
  for (const char* file : {"report.html", "model.json"}) CHECK(fs::exists(folder.path() / "alone" / "third" / file));
}

TEST_CASE("Bundles of one name are refused: they would write to one folder") {
  const std::string command = std::string(TISSUECTL_PROGRAM) + " diagnose a/same b/same --out nowhere 2>/dev/null";
  const int status = std::system(command.c_str());
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 2));
}

#ifdef TISSUED_MPIRUN
TEST_CASE("Two ranks find what one process finds, and print once") {
  const TemporaryFolder folder;
  diagnose_three(folder, "", "alone");
  // Root must insist; a machine of one processor must be allowed two ranks.
  const std::string launcher =
      std::string(TISSUED_MPIRUN) + (::geteuid() == 0 ? " --allow-run-as-root" : "") + " --oversubscribe -n 2 ";
  check_three(diagnose_three(folder, launcher, "ranks"));
  for (const char* bundle : {"first", "third"})
    CHECK(report(folder, "ranks", bundle) == report(folder, "alone", bundle));
}
#else
TEST_CASE("Two ranks find what one process finds, and print once") {
  WARN("No mpirun, or built without MPI: not tested. Install openmpi-bin and libopenmpi-dev.");
}
#endif
