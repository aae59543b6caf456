#include "daemon/ctl_key.hpp"

#include <cstdio>
#include <memory>
#include <string>

#include "config/key_file.hpp"
#include "daemon/ctl_options.hpp"

namespace tissued::daemon {
namespace {

struct KeyArguments {
  std::string name;
  std::string role = "both";
};

int run_key(const KeyArguments& arguments) {
  std::printf("%s\n", config::make_key_line(arguments.name, *config::key_role_of(arguments.role)).c_str());
  return kSuccess;
}

}  // namespace

void add_key_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<KeyArguments>();
  KeyArguments& a = *arguments;
  CLI::App* key = app.add_subcommand("key", "Make a key under which tissued and its peer seal what they send");
  key->footer(
      "Prints one line. tissued's file (`keys`, --keys) has the lines of all its peers, a peer's file its own line\n"
      "alone; both must be readable by their owners alone.\n"
      "Example: umask 077; tissuectl key theatre-1 --role client >>keys");
  key->add_option("NAME", a.name, "Of the peer, at most 24 characters without blanks")->type_name("")->required();
  key->add_option("--role", a.role, "What its owner may do: tracker, client or both")
      ->type_name("ROLE")
      ->check(CLI::IsMember({"tracker", "client", "both"}).description(""))
      ->capture_default_str();
  key->callback([arguments, &exit_code] { exit_code = run_key(*arguments); });
}

}  // namespace tissued::daemon
