// The program itself, as a user or a script starts it.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/daemon/evaluation_bundle.hpp"
#include "tests/daemon/fake_daemon.hpp"
#include "tests/temporary_folder.hpp"

using namespace tissued;
using namespace tissued::daemon;

namespace {

const std::string kDemo = TISSUED_SOURCE_DIR "/config/demo";

struct Outcome {
  int code;
  std::string out;
  std::string err;
};

std::string content(const std::filesystem::path& file) {
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

Outcome run(const std::string& arguments) {
  const TemporaryFolder folder;
  const std::string out = folder.path() / "out", err = folder.path() / "err";
  const std::string command = std::string(TISSUECTL_PROGRAM) + " " + arguments + " >" + out + " 2>" + err;
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, content(out), content(err)};
}

Endpoint nobody() {
  const FakeDaemon daemon({});
  return daemon.clients();
}

}  // namespace

TEST_CASE("Help is no error") {
  for (const char* command : {"", "play ", "track ", "query ", "watch ", "solve ", "effects ", "evaluate ",
                              "calibrate ", "diagnose ", "predict "}) {
    const Outcome outcome = run(std::string(command) + "--help");
    CHECK(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK_THAT(outcome.out, Catch::Contains("Usage:"));
  }
}

TEST_CASE("What effects lists is what solve takes, within the bounds it says") {
  std::istringstream lines(run("effects").out);
  std::string kind;
  int numbers = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    if (line.front() != ' ') {
      kind = line.substr(0, line.find(':'));
      continue;
    }
    std::istringstream cells(line);
    std::string number, to;
    double lowest = 0.0, highest = 0.0;
    REQUIRE(cells >> number >> lowest >> to >> highest);
    CAPTURE(kind, number);
    CHECK(lowest < highest);
    const Outcome beyond = run("solve " + kDemo + " --model fem --element p1 --effect " + kind + " --set " + kind +
                               "." + number + "=" + std::to_string(highest * 1.01));
    CHECK(beyond.code != 0);
    CHECK_THAT(beyond.err, Catch::Contains(kind + "." + number) && Catch::Contains("is not within"));
    ++numbers;
  }
  CHECK(numbers > 14);  // there are so many kinds
}

TEST_CASE("Wrong usage ends with 2 and one line") {
  for (const std::string& arguments : {std::string(""),
                                       std::string("fly"),
                                       std::string("query everything"),
                                       std::string("query targets --from here"),
                                       std::string("query targets --out x.vtu"),
                                       std::string("watch --seconds -1"),
                                       std::string("track"),
                                       "track " + kDemo + " --loss 2",
                                       "track " + kDemo + " --pattern sideways",
                                       "solve " + kDemo + " --model magic",
                                       "solve " + kDemo + " --push A1",
                                       "solve " + kDemo + " --push A1=far",
                                       "solve " + kDemo + " --push A1=1,A1=2",
                                       "solve " + kDemo + " --push A99=1",
                                       "solve " + kDemo + " --gravity 1,2",
                                       "solve " + kDemo + " --out mesh.obj",
                                       "play " + kDemo + " no-such-trial",
                                       "play " + kDemo,
                                       std::string("evaluate"),
                                       "evaluate " + kDemo,
                                       "evaluate " + kDemo + " --out /tmp --models magic",
                                       "evaluate " + kDemo + " --out /tmp --models admm,admm",
                                       "evaluate " + kDemo + " --out /tmp --marker-sets mars",
                                       "evaluate " + kDemo + " --out /tmp --trials exp99",
                                       "evaluate " + kDemo + " --out /tmp --variant nameless",
                                       "evaluate " + kDemo + " --out /tmp --threads 0"}) {
    const Outcome outcome = run(arguments);
    INFO(arguments << ": " << outcome.err);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
  }
}

TEST_CASE("What fails at run time ends with 1 and one line") {
  const std::string dead = to_string(nobody());
  for (const std::string& arguments :
       {"query targets --from " + dead, "watch --seconds 0.5 --from " + dead, std::string("solve /no/such/bundle"),
        "solve " + kDemo + " --set material.poissons_ratio=0.7", "solve " + kDemo + " --mesh /no/such/mesh.msh",
        "track " + kDemo + " --seconds 0.1 --to no-such-host.invalid:5",
        std::string("evaluate /no/such/bundle --out /tmp"),
        "evaluate " + kDemo + " --out /tmp --set simulator.iterations=0",
        "evaluate " + kDemo + " --out /tmp --variant odd:no.such=1"}) {
    const Outcome outcome = run(arguments);
    INFO(arguments << ": " << outcome.err);
    CHECK(outcome.code == 1);
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
  }
}

TEST_CASE("What cannot be written is a failure") {
  if (!std::filesystem::exists("/dev/full")) return;
  const int status = std::system(TISSUECTL_PROGRAM " key theatre >/dev/full 2>/dev/null");
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 1));
}

TEST_CASE("diagnose refuses a bundle in which there is nothing to explain") {
  const TemporaryFolder folder;
  const Outcome outcome = run("diagnose " + kDemo + " --out " + (folder.path() / "result").string());
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err + outcome.out, Catch::Contains("has no trials"));
}

TEST_CASE("query prints what the daemon says") {
  FakeDaemonScript script;
  script.nodes = {{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 12.5}};
  script.tets = {{0, 1, 2, 3}};
  const FakeDaemon daemon(script);
  const std::string from = " --from " + to_string(daemon.clients());
  CHECK_THAT(run("query hello" + from).out, Catch::Contains("9.9.9"));
  CHECK(nlohmann::json::parse(run("query hello --json" + from).out)["targets"] == nlohmann::json({"T1", "T2"}));
  CHECK(nlohmann::json::parse(run("query status --json" + from).out)["counters"]["frames"] == 100);
  CHECK(nlohmann::json::parse(run("query targets --json" + from).out)["validity"] == "no_data");
  const nlohmann::json mesh = nlohmann::json::parse(run("query mesh --json" + from).out);
  CHECK(mesh["nodes_mm"][3][2] == 12.5);
  CHECK(mesh["tetrahedra"] == nlohmann::json({{0, 1, 2, 3}}));
  const TemporaryFolder folder;
  CHECK(run("query mesh --out " + (folder.path() / "now.vtu").string() + from).code == 0);
  CHECK_THAT(content(folder.path() / "now.vtu"), Catch::Contains("UnstructuredGrid") && Catch::Contains("12.5"));
}

TEST_CASE("track sends the same frames again for the same seed") {
  std::vector<protocol::TrackerFrame> frames[2];
  for (auto& received : frames) {
    const FakeDaemon daemon({});
    const Outcome outcome =
        run("track " + kDemo + " --seconds 0.4 --rate 50 --dropout 0.3 --json --to " + to_string(daemon.tracker()));
    REQUIRE(outcome.code == 0);
    CHECK(nlohmann::json::parse(outcome.out)["frames"] == 20);
    received = daemon.frames();
    CHECK(daemon.refused() == 0);
  }
  REQUIRE(frames[0].size() == 20);
  REQUIRE(frames[1].size() == 20);
  for (std::size_t f = 0; f < 20; ++f) {
    REQUIRE(frames[0][f].markers.size() == frames[1][f].markers.size());
    CHECK(frames[0][f].stamp_ns == frames[1][f].stamp_ns);
    for (std::size_t m = 0; m < frames[0][f].markers.size(); ++m) {
      CHECK(frames[0][f].markers[m].position == frames[1][f].markers[m].position);
      CHECK(frames[0][f].markers[m].occluded == frames[1][f].markers[m].occluded);
    }
  }
}

TEST_CASE("watch follows a stream and sums it up") {
  const FakeDaemon daemon({});
  const std::string tracker = std::string(TISSUECTL_PROGRAM) + " track " + kDemo + " --seconds 2 --to " +
                              to_string(daemon.tracker()) + " >/dev/null &";
  REQUIRE(std::system(tracker.c_str()) == 0);
  const Outcome outcome = run("watch --json --seconds 2.2 --from " + to_string(daemon.clients()));
  REQUIRE(outcome.code == 0);
  std::istringstream lines(outcome.out);
  nlohmann::json last;
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) last = nlohmann::json::parse(line);
  CHECK(count == 4);  // at 1, 2 and 2.2 s, and the summary
  CHECK(last["summary"]["frames"].get<int>() > 10);
  CHECK(last["summary"]["targets"]["T1"]["mean_error_mm"].get<double>() == Approx(0.5));
  CHECK(last["summary"]["targets"]["T1"]["max_error_mm"].get<double>() == Approx(0.5));
}

TEST_CASE("solve writes what it found, also when it has not converged") {
  const TemporaryFolder folder;
  const std::string csv = folder.path() / "nodes.csv", curve = folder.path() / "curve.csv";
  const Outcome stopped = run("solve " + kDemo + " --push A1=10 --max-iterations 2 --out " + csv);
  CHECK(stopped.code == 1);
  CHECK_THAT(stopped.err, Catch::Contains("not converged"));
  CHECK_THAT(content(csv), Catch::StartsWith("x,y,z,ux,uy,uz\n"));

  const Outcome solved = run("solve " + kDemo + " --push A1=10 --json --out " + csv + " --curve " + curve);
  REQUIRE(solved.code == 0);
  const nlohmann::json json = nlohmann::json::parse(solved.out);
  CHECK(json["converged"] == true);
  CHECK(json["residual_mm"].get<double>() < 1e-6);
  CHECK(json["pads"]["A1"]["force_N"][0].get<double>() < -0.5);  // it pushes towards -x
  const std::string iterations = content(curve);
  CHECK_THAT(iterations, Catch::StartsWith("iteration,load,residual_mm\n"));
  CHECK(std::count(iterations.begin(), iterations.end(), '\n') == json["iterations"].get<int>() + 1);
}

TEST_CASE("solve answers by finite elements, too, still or with inertia") {
  const TemporaryFolder folder;
  const std::string csv = folder.path() / "nodes.csv", vtu = folder.path() / "pushed.vtu";
  const auto solved = [&](const std::string& options) {
    const Outcome outcome = run("solve " + kDemo + " --push A1=5 --model fem --json " + options);
    REQUIRE(outcome.code == 0);
    return nlohmann::json::parse(outcome.out);
  };
  const auto lines = [&] {
    const std::string text = content(csv);
    return std::count(text.begin(), text.end(), '\n');
  };
  const auto force = [](const nlohmann::json& json) { return json["pads"]["A1"]["force_N"][0].get<double>(); };
  const nlohmann::json linear = solved("--element p1 --out " + csv);
  const auto corners = lines();
  const nlohmann::json quadratic = solved("--out " + csv);
  CHECK(lines() > 5 * corners);                   // with the middles of edges
  CHECK(force(linear) < 1.1 * force(quadratic));  // linear tetrahedra lock
  CHECK(force(quadratic) < -0.2);
  const nlohmann::json moving = solved("--element p1 --dynamic 0.1 --out " + vtu);
  CHECK(moving["load_steps"] == 10);
  CHECK(std::abs(force(moving) - force(linear)) > 1e-3);  // the body has not come to rest
  CHECK_THAT(content(vtu), Catch::Contains("displacement"));

  const Outcome absurd = run("solve " + kDemo + " --push A1=130,A3=130 --model fem --element p1");
  CHECK(absurd.code == 1);
  CHECK_THAT(absurd.err, Catch::Contains("% of the load"));
  for (const char* wrong :
       {" --element p2", " --model fem --element smoothed", " --dynamic 1", " --model fem --curve x", " --effect skin",
        " --model fem --effect magic", " --model fem --effect skin --effect skin",
        " --model fem --effect skin --set skin.thickness=1", " --model fem --effect skin --set skin.stiffness=much",
        " --model fem --effect skin --set skin.stiffness=-1", " --model fem --set skin.stiffness=1", " --hold 1",
        " --model fem --dynamic 1 --hold 1"})
    CHECK(run("solve " + kDemo + wrong).code == 2);
}

TEST_CASE("solve asks what effects would change, and says them in words") {
  const auto force = [](const std::string& options) {
    const Outcome outcome = run("solve " + kDemo + " --push A1=5 --model fem --element p1 --json " + options);
    REQUIRE(outcome.code == 0);
    const nlohmann::json answer = nlohmann::json::parse(outcome.out);
    return std::pair{-answer["pads"]["A1"]["force_N"][0].get<double>(), answer["effects"]};
  };
  const auto plain = force("");
  CHECK(plain.second.empty());
  const auto skin = force("--effect skin --set skin.stiffness=50");
  CHECK(skin.first > 1.02 * plain.first);
  CHECK(skin.second[0]["parameters"]["stiffness"] == 50.0);
  const std::string relaxing = "--effect viscoelasticity --set viscoelasticity.g1=0.5 --set viscoelasticity.tau1=1 ";
  CHECK(force(relaxing).first == Approx(plain.first).epsilon(1e-6));
  CHECK(force(relaxing + "--hold 1").first < 0.9 * plain.first);
  CHECK(force(relaxing + "--hold 20").first < 0.8 * plain.first);
  const Outcome words = run("solve " + kDemo +
                            " --push A1=5 --model fem --element p1 --effect gravity "
                            "--set gravity.gravity.z=-1 --set material.youngs_modulus=20");
  CHECK_THAT(words.out, Catch::Contains("The tissue's weight acts with 1.00 g along (0.00, 0.00, -1.00)."));
}

TEST_CASE("solve runs particles to rest and says what that took") {
  const std::string push = "solve " + kDemo + " --push A1=5 --model pbd --json ";
  const Outcome outcome = run(push);
  REQUIRE(outcome.code == 0);
  const nlohmann::json answer = nlohmann::json::parse(outcome.out);
  CHECK(answer["iterations"] == 27 * answer["time_steps"].get<int>());
  CHECK(answer["residual_mm"] <= 1e-4);
  CHECK(answer["pads"]["A1"]["force_N"] == nlohmann::json({0.0, 0.0, 0.0}));
  const Outcome coarse = run(push + "--set simulator.pbd.particle_spacing=8");
  REQUIRE(coarse.code == 0);
  CHECK(nlohmann::json::parse(coarse.out)["particles"] < answer["particles"]);
  CHECK(run(push + "--max-iterations 30").code == 1);
  CHECK_THAT(run(push + "--element p1").err, Catch::Contains("pbd has no p1"));
  CHECK_THAT(run(push + "--set simulator.pbd.cluster_radius=3").err, Catch::Contains("below half of cluster_spacing"));
}

TEST_CASE("calibrate writes a configuration, goes on where it was, and fine-tunes from it") {
  const TemporaryFolder folder;
  const std::string bundle = write_evaluation_bundle(folder), out = folder.path() / "first",
                    fine = folder.path() / "fine";
  const std::string vary = "calibrate " + bundle +
                           " --model pbd --vary simulator.pbd.cluster_radius=6..15 --vary "
                           "simulator.pbd.cluster_stiffness=0.1..0.9 --set simulator.pbd.particle_spacing=8 ";
  const std::string command = vary + "--population 8 --generations 2 --seed 5 --out " + out;
  const Outcome outcome = run(command);
  REQUIRE(outcome.code == 0);
  CHECK_THAT(outcome.err, Catch::Contains("of at most 24 points"));
  const std::string trace = content(out + "/evaluations.csv"), config = content(out + "/config.json");
  const auto points = std::count(trace.begin(), trace.end(), '\n') - 2;
  CHECK(points >= 12);  // children that are like somebody before are not played again
  CHECK(points <= 24);
  CHECK_THAT(content(out + "/index.html"),
             Catch::StartsWith("<!DOCTYPE html>") && Catch::Contains("cluster_radius") && Catch::EndsWith("</html>\n"));
  const Outcome again = run(command);
  CHECK(again.err.empty());  // nothing is left to evaluate
  CHECK(again.out == outcome.out);
  CHECK(content(out + "/config.json") == config);
  const Outcome tuned = run(vary + "--start " + out + "/config.json --target T1 --evaluations 6 --out " + fine);
  CHECK(tuned.code == 0);
  CHECK(nlohmann::json::parse(content(fine + "/config.json"))["simulator"]["pbd"]["particle_spacing"] == 8);
  CHECK(run(vary + "--seed 6 --population 8 --generations 2 --out " + out).code == 2);
  CHECK_THAT(run("calibrate " + bundle + " --model pbd --vary simulator.pbd.cluster_radius=6 --out " + out).err,
             Catch::Contains("is not KEY=LOW..HIGH"));
}

#ifdef TISSUED_MPIRUN
TEST_CASE("calibrate asks for the same points and finds the same however many ranks share its trials") {
  const TemporaryFolder folder;
  const std::string command = "calibrate " + write_evaluation_bundle(folder).string() +
                              " --model pbd --vary simulator.pbd.cluster_radius=6..15 --set "
                              "simulator.pbd.particle_spacing=8 --population 8 --generations 2 --out ";
  REQUIRE(run(command + (folder.path() / "alone").string()).code == 0);
  const std::string launcher =
      std::string(TISSUED_MPIRUN) + (::geteuid() == 0 ? " --allow-run-as-root" : "") + " --oversubscribe -n 3 ";
  const std::string out = (folder.path() / "ranks").string();
  REQUIRE(std::system((launcher + TISSUECTL_PROGRAM " " + command + out + " >/dev/null 2>&1").c_str()) == 0);
  for (const char* file : {"/evaluations.csv", "/config.json"})
    CHECK(content(out + file) == content((folder.path() / "alone").string() + file));
}
#endif

TEST_CASE("evaluate writes scores and a page, and sums them up") {
  const TemporaryFolder folder;
  const std::string bundle = write_evaluation_bundle(folder), out = folder.path() / "result";
  const Outcome outcome =
      run("evaluate " + bundle + " --models admm,kf-admm --marker-sets most --threads 2 --frames --out " + out);
  REQUIRE(outcome.code == 0);
  CHECK_THAT(outcome.err, Catch::Contains("4 of 4 runs"));
  CHECK_THAT(outcome.out, Catch::Contains("kf-admm") && Catch::Contains("index.html"));
  const std::string runs = content(out + "/runs.csv"), frames = content(out + "/frames.csv");
  CHECK_THAT(runs, Catch::StartsWith("bundle,trial,model,marker_set,target,"));
  CHECK(std::count(runs.begin(), runs.end(), '\n') == 1 + 4);
  CHECK(std::count(frames.begin(), frames.end(), '\n') == 1 + 4 * static_cast<int>(kCubeFrames));
  CHECK_THAT(content(out + "/index.html"), Catch::StartsWith("<!DOCTYPE html>") && Catch::EndsWith("</html>\n"));
}

TEST_CASE("evaluate refuses a folder that it cannot write before it runs") {
  const TemporaryFolder folder;
  const std::string bundle = write_evaluation_bundle(folder);
  const std::string file = folder.write("taken", "");
  const Outcome outcome = run("evaluate " + bundle + " --out " + file + "/below");
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err, Catch::Contains("taken/below") && !Catch::Contains("runs,"));
}

TEST_CASE("predict writes what a model says of a trial, and what was recorded of it") {
  const TemporaryFolder folder;
  const std::string bundle = write_evaluation_bundle(folder).string();
  const std::string predicted = bundle + "/predicted.csv", recorded = bundle + "/recorded.csv";
  const Outcome outcome = run("predict " + bundle + " --trial deep --out " + predicted + " --recorded " + recorded);
  INFO(outcome.err);
  REQUIRE(outcome.code == 0);
  const protocol::Trial truth = protocol::read_nexus_csv(bundle + "/deep.csv");
  const protocol::Trial seen = protocol::read_nexus_csv(recorded), said = protocol::read_nexus_csv(predicted);
  REQUIRE(seen.frame_count == truth.frame_count);
  REQUIRE(said.frame_count == truth.frame_count);
  const std::size_t in_truth = truth.find_label("M2").value(), in_seen = seen.find_label("M2").value();
  for (std::size_t f = 0; f < truth.frame_count; ++f) {
    REQUIRE(seen.is_seen(f, in_seen) == truth.is_seen(f, in_truth));
    CHECK(said.is_seen(f, said.find_label("M2").value()));
    for (std::size_t axis = 0; axis < 3 && truth.is_seen(f, in_truth); ++axis)
      CHECK(seen.position(f, in_seen)[axis] == Approx(truth.position(f, in_truth)[axis]).margin(1e-9));
  }
  const Outcome unknown = run("predict " + bundle + " --trial nonesuch --out " + predicted);
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Catch::Contains("--trial") && Catch::Contains("nonesuch"));
}
