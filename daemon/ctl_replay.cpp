#include "daemon/ctl_replay.hpp"

#include <unistd.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/ctl_options.hpp"
#include "daemon/session_replay.hpp"

namespace tissued::daemon {
namespace {

struct ReplayArguments {
  std::string file, bundle;
  bool json = false;
};

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

void print_json(const ReplayReport& report) {
  nlohmann::json object{{"frames", report.frames},
                        {"steps", report.steps},
                        {"equal", report.equal},
                        {"state", hex(report.state_hash)},
                        {"same", report.is_same()},
                        {"lost", report.lost},
                        {"damaged_bytes", report.damaged_bytes},
                        {"torn", report.torn}};
  object["recorded_state"] = nullptr;
  object["first_unequal"] = nullptr;
  if (report.recorded_hash) object["recorded_state"] = hex(*report.recorded_hash);
  if (report.first_unequal) object["first_unequal"] = *report.first_unequal;
  std::puts(object.dump().c_str());
}

void print_words(const ReplayReport& report) {
  std::printf("%zu frames, %zu steps repeated, %zu equal in every bit\n", report.frames, report.steps, report.equal);
  if (report.first_unequal)
    std::printf("frame %u is the first that differs: %s\n", *report.first_unequal, report.difference.c_str());
  const std::string recorded = !report.recorded_hash ? "the recording ends without one: tissued was killed"
                               : *report.recorded_hash == report.state_hash
                                   ? "as recorded"
                                   : "recorded was " + hex(*report.recorded_hash);
  std::printf("state %s, %s\n", hex(report.state_hash).c_str(), recorded.c_str());
  if (report.lost > 0)
    std::printf("%llu records were lost while recording\n", static_cast<unsigned long long>(report.lost));
  if (report.damaged_bytes > 0)
    std::printf("%zu bytes belong to no whole record%s\n", report.damaged_bytes,
                report.torn ? "; the end is torn" : "");
}

int run_replay(const ReplayArguments& arguments) {
  const bool terminal = isatty(STDERR_FILENO) == 1;
  const ReplayReport report =
      replay_session(arguments.file, arguments.bundle, [terminal](std::size_t done, std::size_t of) {
        constexpr std::size_t kBetween = 100;
        if (terminal && (done % kBetween == 0 || done == of))
          std::fprintf(stderr, done == of ? "\r\x1b[K" : "\r%zu of %zu steps\x1b[K", done, of);
      });
  arguments.json ? print_json(report) : print_words(report);
  return report.is_same() ? kSuccess : kFailure;
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ReplayArguments>();
  ReplayArguments& a = *arguments;
  CLI::App* command = app.add_subcommand("replay", "Repeat what `tissued --record` has recorded, bit for bit");
  command->footer(
      "Steps the same frames with the same configuration, as fast as it can, and compares every answer and the state "
      "at\n"
      "the end. Ends with 1 where a bit differs: another build, another kind of processor, or another model file.\n"
      "Example: tissuectl replay live.rec");
  command->add_option("FILE", a.file, "Recording of tissued")->type_name("")->required();
  command->add_option("--bundle", a.bundle, "The bundle that was recorded with; default: where it was then")
      ->type_name("DIR");
  command->add_flag("--json", a.json, "Print the summary as JSON");
  command->callback([arguments, &exit_code] { exit_code = run_replay(*arguments); });
}

}  // namespace tissued::daemon
