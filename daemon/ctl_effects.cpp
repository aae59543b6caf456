#include "daemon/ctl_effects.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "core/effects/effect.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/text_table.hpp"

namespace tissued::daemon {
namespace {

std::string shortest(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

int run_effects() {
  for (const core::Effect* effect : core::effects()) {
    std::printf("%s: %s\n", std::string(effect->kind()).c_str(), std::string(effect->title()).c_str());
    TextTable table;
    for (const core::EffectParameter& parameter : effect->parameters())
      table.add_row({"  " + parameter.name, shortest(parameter.lowest), "to", shortest(parameter.highest),
                     parameter.unit == "1" ? "" : parameter.unit});
    std::printf("%s\n", table.text().c_str());
  }
  return kSuccess;
}

}  // namespace

void add_effects_command(CLI::App& app, int& exit_code) {
  CLI::App* effects =
      app.add_subcommand("effects", "Physics that solve can add and diagnose can find, and its numbers");
  effects->footer(
      "Numbers are set by --set KIND.NUMBER=VALUE of solve; what is not set stays as where the effect is absent.\n"
      "Example: tissuectl solve BUNDLE --model fem --effect skin --set skin.stiffness=50 --push A1=10");
  effects->callback([&exit_code] { exit_code = run_effects(); });
}

}  // namespace tissued::daemon
