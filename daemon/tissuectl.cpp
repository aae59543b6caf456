// The client of tissued, and a workbench beside it. One subcommand, one file pair.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "daemon/ctl_calibrate.hpp"
#include "daemon/ctl_diagnose.hpp"
#include "daemon/ctl_effects.hpp"
#include "daemon/ctl_evaluate.hpp"
#include "daemon/ctl_export.hpp"
#include "daemon/ctl_key.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/ctl_play.hpp"
#include "daemon/ctl_query.hpp"
#include "daemon/ctl_replay.hpp"
#include "daemon/ctl_solve.hpp"
#include "daemon/ctl_track.hpp"
#include "daemon/ctl_watch.hpp"
#include "daemon/terminal.hpp"

namespace {

constexpr const char* kAbout =
    "Client and workbench of tissued, the daemon that tells where the inside of soft tissue is.\n"
    "Units: mm, s, kPa, N, g/cm3. A BUNDLE is a folder with bundle.json, a mesh and recorded trials.";
constexpr const char* kFooter = "`tissuectl COMMAND --help` tells more. Exit codes: 0 done, 1 failed, 2 wrong usage.";

std::string one_line(const CLI::App*, const CLI::Error& error) {
  return "tissuectl: " + std::string(error.what()) + " (--help tells more)\n";
}

}  // namespace

int main(int argc, char** argv) {
  using namespace tissued::daemon;
  CLI::App app(kAbout, "tissuectl");
  app.footer(kFooter);
  app.failure_message(one_line);
  app.require_subcommand(1);
  int exit_code = kSuccess;
  add_play_command(app, exit_code);
  add_track_command(app, exit_code);
  add_query_command(app, exit_code);
  add_watch_command(app, exit_code);
  add_solve_command(app, exit_code);
  add_effects_command(app, exit_code);
  add_evaluate_command(app, exit_code);
  add_calibrate_command(app, exit_code);
  add_diagnose_command(app, exit_code);
  add_predict_command(app, exit_code);
  add_export_command(app, exit_code);
  add_replay_command(app, exit_code);
  add_key_command(app, exit_code);
  try {
    app.parse(argc, argv);  // which runs the subcommand
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSuccess : kUsage;
  } catch (const UsageError& error) {
    std::fprintf(stderr, "tissuectl: %s\n", error.what());
    return kUsage;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tissuectl: %s\n", error.what());
    return kFailure;
  }
  if (!stdout_is_written()) {
    std::fprintf(stderr, "tissuectl: standard output: cannot be written\n");
    return kFailure;
  }
  return exit_code;
}
