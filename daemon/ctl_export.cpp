#include "daemon/ctl_export.hpp"

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "daemon/ctl_options.hpp"
#include "daemon/session_export.hpp"

namespace tissued::daemon {
namespace {

struct ExportArguments {
  std::string file, bundle, out;
  bool json = false;
};

int run_export(const ExportArguments& arguments) {
  const ExportReport report = export_session(arguments.file, arguments.bundle, arguments.out);
  if (arguments.json) {
    const nlohmann::json object{{"seconds", report.seconds},
                                {"records", report.records},
                                {"frames", report.frames},
                                {"lost", report.lost},
                                {"damaged_bytes", report.damaged_bytes},
                                {"torn", report.torn},
                                {"trials", report.trials},
                                {"held_out", report.held_out}};
    std::puts(object.dump().c_str());
    return kSuccess;
  }
  std::printf("%s: %.1f s, %zu tracker frames; %zu trials, %zu of them held out\n", arguments.out.c_str(),
              report.seconds, report.frames, report.trials.size() + report.held_out.size(), report.held_out.size());
  if (report.lost > 0)
    std::printf("%llu records were lost while recording\n", static_cast<unsigned long long>(report.lost));
  if (report.damaged_bytes > 0)
    std::printf("%zu bytes belong to no whole record%s\n", report.damaged_bytes,
                report.torn ? "; the end is torn" : "");
  return kSuccess;
}

}  // namespace

void add_export_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<ExportArguments>();
  ExportArguments& a = *arguments;
  CLI::App* command = app.add_subcommand("export", "Make a bundle of what `tissued --record` has recorded");
  command->footer(
      "Every push becomes a trial, every fourth one held out. What is torn off or damaged is left out, and said.\n"
      "Example: tissuectl export live.rec --out live && tissuectl diagnose live --out result");
  command->add_option("FILE", a.file, "Recording of tissued")->type_name("")->required();
  command->add_option("--out", a.out, "Folder of the new bundle")->type_name("DIR")->required();
  command->add_option("--bundle", a.bundle, "The bundle that was recorded with; default: where it was then")
      ->type_name("DIR");
  command->add_flag("--json", a.json, "Print the summary as JSON");
  command->callback([arguments, &exit_code] { exit_code = run_export(*arguments); });
}

}  // namespace tissued::daemon
