#include "daemon/ctl_solve.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>

#include "config/daemon_config.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/scene_loader.hpp"
#include "daemon/static_answer.hpp"
#include "daemon/text_table.hpp"
#include "protocol/displacement_csv.hpp"
#include "protocol/vtk_file.hpp"

namespace tissued::daemon {
namespace {

struct SolveArguments {
  std::string bundle;
  std::string model = "admm";
  std::vector<std::string> pushes;
  std::string gravity;
  std::vector<std::string> overrides;
  std::vector<std::string> simulator_settings;  // of the overrides those that are
  std::vector<std::string> effects;
  std::string mesh;
  std::string out;
  std::string curve;
  std::string element;
  std::optional<double> tolerance;
  core::StaticOptions admm;
  FemRun fem;
  bool json = false;
};

double parse_number(const std::string& text, const std::string& what) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) {
    throw UsageError(what + ": `" + text + "` is not a number");
  }
  return value;
}

// A1=10: the pad's name and mm along its direction.
std::map<std::string, double> parse_pushes(const std::vector<std::string>& texts) {
  std::map<std::string, double> pushes;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) throw UsageError("--push: `" + text + "` is not PAD=MM");
    const std::string pad = text.substr(0, equals);
    if (!pushes.emplace(pad, parse_number(text.substr(equals + 1), "--push " + pad)).second) {
      throw UsageError("--push: pad " + pad + " is given twice");
    }
  }
  return pushes;
}

// `x,y,z` as the override of bundle.json that it stands for.
std::string gravity_override(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> parts;
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  if (parts.size() != 3) throw UsageError("--gravity: `" + text + "` is not x,y,z in multiples of g0");
  nlohmann::json vector = nlohmann::json::array();
  for (const std::string& part : parts) vector.push_back(parse_number(part, "--gravity"));
  return "gravity=" + vector.dump();
}

core::Scene load_static_scene(const SolveArguments& arguments) {
  std::vector<std::string> overrides = arguments.overrides;
  if (!arguments.gravity.empty()) overrides.push_back(gravity_override(arguments.gravity));
  config::Bundle bundle = config::load_bundle(arguments.bundle, overrides);
  if (!arguments.mesh.empty()) bundle.mesh_file = arguments.mesh;
  return load_scene(bundle);
}

// A pad that is not named is off the skin.
std::vector<core::PadInput> pad_inputs(const core::Scene& scene, std::map<std::string, double> pushes) {
  const double size = (scene.mesh.rest.colwise().maxCoeff() - scene.mesh.rest.colwise().minCoeff()).maxCoeff();
  std::vector<core::PadInput> inputs(scene.pads.size());
  for (std::size_t i = 0; i < scene.pads.size(); ++i) {
    const auto push = pushes.find(scene.pads[i].name);
    if (push == pushes.end()) continue;
    inputs[i].kind = core::PadInput::Kind::pose;
    if (!(std::abs(push->second) <= size))
      throw UsageError("--push: " + scene.pads[i].name + " by " + fixed(push->second, 1) +
                       " mm is more than the body's own size, " + fixed(size, 1) + " mm");
    inputs[i].center = scene.pads[i].center + push->second * scene.pads[i].direction;
    pushes.erase(push);
  }
  if (!pushes.empty()) {
    std::vector<std::string> known;
    for (const core::Pad& pad : scene.pads) known.push_back(pad.name);
    throw UsageError("--push: there is no pad " + pushes.begin()->first + "; the bundle has " +
                     (known.empty() ? "none" : join_or(known)));
  }
  return inputs;
}

void write_answer(const std::filesystem::path& path, const core::Scene& scene, const StaticAnswer& answer) {
  if (path.extension() == ".csv") {
    protocol::write_displacement_csv({answer.rest, answer.displacement}, path);
    return;
  }
  // The corners of quadratic tetrahedra only: they are the mesh's own nodes.
  const auto nodes = static_cast<std::size_t>(scene.mesh.node_count());
  std::vector<std::array<double, 3>> positions(nodes);
  for (std::size_t i = 0; i < nodes; ++i)
    for (std::size_t axis = 0; axis < 3; ++axis)
      positions[i][axis] = answer.rest[i][axis] + answer.displacement[i][axis];
  std::vector<std::array<std::int32_t, 4>> tets;
  for (const core::Tet& tet : scene.mesh.tets) tets.push_back({tet[0], tet[1], tet[2], tet[3]});
  const protocol::PointField displacement{"displacement", 3, {answer.displacement.front().data(), 3 * nodes}};
  protocol::write_vtu(path, positions, tets, {&displacement, 1});
}

void write_curve(const std::string& path, const std::vector<core::StaticIteration>& iterations) {
  std::ofstream file(path);
  file << "iteration,load,residual_mm\n";
  for (const core::StaticIteration& i : iterations) file << i.iteration << ',' << i.load << ',' << i.residual << '\n';
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

nlohmann::json vector_json(const core::Vec3& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::json answer_json(const core::Scene& scene, const std::vector<core::PadInput>& inputs,
                           const StaticAnswer& answer, const std::vector<core::EffectSetting>& effects) {
  nlohmann::json pads = nlohmann::json::object(), displacement = nlohmann::json::object();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (inputs[i].kind == core::PadInput::Kind::absent) continue;
    pads[scene.pads[i].name] = {{"force_N", vector_json(answer.pad_forces[i])}};
  }
  for (std::size_t i = 0; i < scene.markers.size(); ++i)
    displacement[scene.markers[i].name] = vector_json(answer.markers[i]);
  for (std::size_t i = 0; i < scene.targets.size(); ++i)
    displacement[scene.targets[i].name] = vector_json(answer.targets[i]);
  nlohmann::json all = answer.figures;
  all.update({{"converged", answer.converged},
              {"trouble", answer.trouble},
              {"pads", pads},
              {"effects", effects_json(effects)},
              {"displacement_mm", displacement}});
  return all;
}

void print_answer(const core::Scene& scene, const std::vector<core::PadInput>& inputs, const StaticAnswer& answer) {
  std::printf("%s after %s\n", answer.converged ? "converged" : "NOT CONVERGED", answer.summary.c_str());
  TextTable table;
  const auto add_row = [&table](const std::string& name, const core::Vec3& v) {
    table.add_row({name, fixed(v.x(), 4), fixed(v.y(), 4), fixed(v.z(), 4)});
  };
  table.add_row({"", "x", "y", "z"});
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const bool absent = inputs[i].kind == core::PadInput::Kind::absent;
    if (!absent) add_row("force of " + scene.pads[i].name + ", N", answer.pad_forces[i]);
  }
  for (std::size_t i = 0; i < scene.targets.size(); ++i)
    add_row("displacement of " + scene.targets[i].name + ", mm", answer.targets[i]);
  std::fputs(table.text().c_str(), stdout);
}

bool is_fem(const SolveArguments& arguments) { return arguments.model == "fem"; }
bool is_pbd(const SolveArguments& arguments) { return arguments.model == "pbd"; }

// What --set says of the simulator is the configuration's, and not the bundle's.
std::vector<std::string> take_simulator_settings(std::vector<std::string>& settings) {
  const auto of_bundle = std::stable_partition(
      settings.begin(), settings.end(), [](const std::string& setting) { return !setting.starts_with("simulator."); });
  std::vector<std::string> taken(of_bundle, settings.end());
  settings.erase(of_bundle, settings.end());
  return taken;
}

// Options that the chosen model does not have.
void check_model(const SolveArguments& arguments) {
  const std::string& element = arguments.element;
  if (!element.empty() &&
      (is_pbd(arguments) || (element != "p1" && element != (is_fem(arguments) ? "p2" : "smoothed"))))
    throw UsageError("--element: " + arguments.model + " has no " + element);
  if (arguments.model != "admm" && !arguments.curve.empty())
    throw UsageError("--curve: " + arguments.model + " has none");
  if (!is_fem(arguments) && arguments.fem.duration > 0.0) throw UsageError("--dynamic: only fem has inertia here");
  if (!is_fem(arguments) && !arguments.effects.empty()) throw UsageError("--effect: only fem has effects here");
  if (arguments.fem.hold > 0.0 && (!is_fem(arguments) || arguments.fem.duration > 0.0))
    throw UsageError("--hold: only for fem, without --dynamic");
}

StaticAnswer solve(const SolveArguments& arguments, const core::Scene& scene, const std::vector<core::PadInput>& inputs,
                   const std::vector<core::EffectSetting>& effects) {
  if (is_fem(arguments)) {
    FemRun run = arguments.fem;
    run.effects = effects;
    if (arguments.element == "p1") run.element = core::FemElement::p1;
    if (arguments.tolerance) run.tolerance = *arguments.tolerance;
    return answer_of_fem(scene, inputs, run);
  }
  if (is_pbd(arguments)) {
    PbdRun run;
    run.options = config::config_for_bundle(arguments.bundle, arguments.simulator_settings).simulator.pbd;
    run.load_step = arguments.admm.load_step;
    run.max_iterations = arguments.admm.max_iterations;
    if (arguments.tolerance) run.tolerance = *arguments.tolerance;
    return answer_of_pbd(scene, inputs, run);
  }
  core::StaticOptions options = arguments.admm;
  if (arguments.element == "p1") options.element = core::Element::p1;
  if (arguments.tolerance) options.tolerance = *arguments.tolerance;
  std::vector<core::StaticIteration> iterations;
  const auto watch = [&iterations](const core::StaticIteration& iteration) { iterations.push_back(iteration); };
  const StaticAnswer answer = answer_of_admm(scene, inputs, options, watch);
  if (!arguments.curve.empty()) write_curve(arguments.curve, iterations);
  return answer;
}

int run_solve(SolveArguments arguments) {
  const std::string extension = std::filesystem::path(arguments.out).extension().string();
  if (!arguments.out.empty() && extension != ".csv" && extension != ".vtu") {
    throw UsageError("--out: " + arguments.out + " ends neither in .csv nor in .vtu");
  }
  check_model(arguments);
  const std::map<std::string, double> pushes = parse_pushes(arguments.pushes);
  const std::vector<std::string> settings = take_effect_settings(arguments.effects, arguments.overrides);
  if (is_pbd(arguments)) arguments.simulator_settings = take_simulator_settings(arguments.overrides);
  const core::Scene scene = load_static_scene(arguments);
  const std::vector<core::EffectSetting> effects = choose_effects(scene, arguments.effects, settings);
  const std::vector<core::PadInput> inputs = pad_inputs(scene, pushes);
  const StaticAnswer answer = solve(arguments, scene, inputs, effects);
  if (!arguments.out.empty()) write_answer(arguments.out, scene, answer);
  if (arguments.json) {
    std::puts(answer_json(scene, inputs, answer, effects).dump(1).c_str());
  } else {
    for (const core::EffectSetting& chosen : effects)
      std::printf("%s\n", chosen.effect->sentence(chosen.values).c_str());
    print_answer(scene, inputs, answer);
  }
  if (answer.converged) return kSuccess;
  std::fprintf(stderr, "tissuectl: not converged%s%s; what was reached is %s\n", answer.trouble.empty() ? "" : ": ",
               answer.trouble.c_str(), arguments.out.empty() ? "printed" : ("in " + arguments.out).c_str());
  return kFailure;
}

}  // namespace

void add_solve_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<SolveArguments>();
  SolveArguments& a = *arguments;
  CLI::App* solve = app.add_subcommand("solve", "The static answer to a push, without a daemon: what if?");
  solve->footer(
      "Prints pad forces and the displacement of every target. Not converged: says so, writes what was reached, exit "
      "1.\n"
      "Example: tissuectl solve recordings/paper/table1 --push A1=10,A3=15 --out pushed.vtu");
  solve->add_option("BUNDLE", a.bundle, "Folder with bundle.json")->type_name("")->required();
  solve->add_option("--model", a.model, "Simulator: admm, fem or pbd")
      ->type_name("NAME")
      ->check(CLI::IsMember({"admm", "fem", "pbd"}).description(""))
      ->capture_default_str();
  solve->add_option("--element", a.element, "Of admm: smoothed (default) or p1; of fem: p2 (default) or p1")
      ->type_name("NAME")
      ->check(CLI::IsMember({"smoothed", "p1", "p2"}).description(""));
  solve
      ->add_option("--dynamic", a.fem.duration,
                   "With inertia (fem): the pads travel evenly for so many seconds; the answer is the end of it")
      ->type_name("S")
      ->check(in_range(1e-6, 1e4));
  solve->add_option("--time-step", a.fem.time_step, "Of --dynamic, s")
      ->type_name("S")
      ->check(in_range(1e-6, 10.0))
      ->capture_default_str();
  solve
      ->add_option("--push", a.pushes,
                   "PAD=MM, parted by commas: pads that touch, and how far each is pushed along its "
                   "direction; pads not named are off the skin")
      ->type_name("PAD=MM")
      ->delimiter(',')
      ->allow_extra_args(false);
  solve->add_option("--gravity", a.gravity, "x,y,z in multiples of g0; the bundle's unless given")->type_name("X,Y,Z");
  solve
      ->add_option("--set", a.overrides,
                   "KEY=VALUE of bundle.json, e.g. material.poissons_ratio=0.42, or of an effect, e.g. "
                   "viscoelasticity.g1=0.4, or of pbd, e.g. simulator.pbd.cluster_radius=9; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  solve
      ->add_option("--effect", a.effects,
                   "Physics that the bundle does not assume (fem), whose numbers `tissuectl effects` lists: " +
                       join_or(effect_kinds()))
      ->type_name("KIND")
      ->allow_extra_args(false);
  solve->add_option("--hold", a.fem.hold, "The pads stay for so many seconds, for effects with memory (fem)")
      ->type_name("S")
      ->check(in_range(1e-6, 1e6));
  solve->add_option("--mesh", a.mesh, "Another mesh than the bundle's, with the same surface groups")
      ->type_name("FILE");
  solve
      ->add_option("--tolerance", a.tolerance,
                   "Residual at which it has converged, mm; 1e-6 for admm, 1e-8 for fem unless given; of pbd the "
                   "largest move in a time step, 1e-4")
      ->type_name("MM")
      ->check(in_range(1e-14, 10.0));
  solve->add_option("--max-iterations", a.admm.max_iterations, "Give up after as many iterations of admm or pbd")
      ->type_name("N")
      ->check(in_range(1, 1e7))
      ->capture_default_str();
  solve
      ->add_option("--anderson", a.admm.anderson_depth, "Iterations that the acceleration looks back; 0 for plain ADMM")
      ->type_name("N")
      ->check(in_range(0, 50))
      ->capture_default_str();
  solve
      ->add_option("--load-step", a.admm.load_step,
                   "Pads move by at most this much at a time, mm; of pbd in a time step")
      ->type_name("MM")
      ->check(in_range(1e-3, 1e6))
      ->capture_default_str();
  solve
      ->add_option("--out", a.out,
                   "Nodes: x,y,z,ux,uy,uz as .csv (of p2 with the middles of edges), or the deformed mesh as .vtu")
      ->type_name("FILE");
  solve->add_option("--curve", a.curve, "Convergence as .csv: iteration, load, residual")->type_name("FILE");
  solve->add_flag("--json", a.json, "Print JSON, with the displacement of every marker and target");
  solve->callback([arguments, &exit_code] { exit_code = run_solve(*arguments); });
}

}  // namespace tissued::daemon
