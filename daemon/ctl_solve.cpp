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
#include <sstream>
#include <string>

#include "core/static_solve.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/scene_loader.hpp"
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
  std::string mesh;
  std::string out;
  std::string curve;
  core::StaticOptions options;
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
  std::vector<core::PadInput> inputs(scene.pads.size());
  for (std::size_t i = 0; i < scene.pads.size(); ++i) {
    const auto push = pushes.find(scene.pads[i].name);
    if (push == pushes.end()) continue;
    inputs[i].kind = core::PadInput::Kind::pose;
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

struct NodeColumns {
  std::vector<std::array<double, 3>> rest, position, displacement;  // (n x 3) mm
};

NodeColumns node_columns(const core::Scene& scene, const core::StaticSolution& solution) {
  NodeColumns columns;
  for (int i = 0; i < scene.mesh.node_count(); ++i) {
    const core::Vec3 rest = scene.mesh.node(i);
    const core::Vec3 now = solution.positions.row(i).head<3>().transpose();
    const core::Vec3 moved = now - rest;
    columns.rest.push_back({rest.x(), rest.y(), rest.z()});
    columns.position.push_back({now.x(), now.y(), now.z()});
    columns.displacement.push_back({moved.x(), moved.y(), moved.z()});
  }
  return columns;
}

void write_solution(const std::filesystem::path& path, const core::Scene& scene, const core::StaticSolution& solution) {
  const NodeColumns columns = node_columns(scene, solution);
  if (path.extension() == ".csv") {
    protocol::write_displacement_csv({columns.rest, columns.displacement}, path);
    return;
  }
  std::vector<std::array<std::int32_t, 4>> tets;
  for (const core::Tet& tet : scene.mesh.tets) tets.push_back({tet[0], tet[1], tet[2], tet[3]});
  const protocol::PointField displacement{
      "displacement", 3, {columns.displacement.front().data(), 3 * columns.displacement.size()}};
  protocol::write_vtu(path, columns.position, tets, {&displacement, 1});
}

void write_curve(const std::string& path, const std::vector<core::StaticIteration>& iterations) {
  std::ofstream file(path);
  file << "iteration,load,residual_mm\n";
  for (const core::StaticIteration& i : iterations) file << i.iteration << ',' << i.load << ',' << i.residual << '\n';
  file.close();
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

core::Vec3 displacement_of(const core::Scene& scene, const core::StaticSolution& solution, const core::Vec3& rest) {
  const core::MaterialPoint point = core::locate_in_volume(scene.mesh, rest);
  core::Vec3 moved = core::Vec3::Zero();
  for (std::size_t a = 0; a < 4; ++a) {
    const core::Vec3 now = solution.positions.row(point.nodes[a]).head<3>().transpose();
    moved += point.weights[a] * (now - scene.mesh.node(point.nodes[a]));
  }
  return moved;
}

nlohmann::json vector_json(const core::Vec3& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::json solution_json(const core::Scene& scene, const std::vector<core::PadInput>& inputs,
                             const core::StaticSolution& solution) {
  nlohmann::json pads = nlohmann::json::object();
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    if (inputs[i].kind == core::PadInput::Kind::absent) continue;
    pads[scene.pads[i].name] = {{"force_N", vector_json(solution.pad_forces[i])}};
  }
  nlohmann::json displacement = nlohmann::json::object();
  for (const auto& m : scene.markers) displacement[m.name] = vector_json(displacement_of(scene, solution, m.rest));
  for (const auto& t : scene.targets) displacement[t.name] = vector_json(displacement_of(scene, solution, t.rest));
  return {{"converged", solution.converged},
          {"trouble", solution.trouble},
          {"iterations", solution.iterations},
          {"residual_mm", solution.residual},
          {"force_residual_N", solution.force_residual},
          {"inverted", solution.inverted},
          {"pads", pads},
          {"displacement_mm", displacement}};
}

void print_solution(const core::Scene& scene, const std::vector<core::PadInput>& inputs,
                    const core::StaticSolution& solution) {
  std::printf("%s after %d iterations: residual %.2e mm, largest unbalanced force %.2e N\n",
              solution.converged ? "converged" : "NOT CONVERGED", solution.iterations, solution.residual,
              solution.force_residual);
  TextTable table;
  const auto add_row = [&table](const std::string& name, const core::Vec3& v) {
    table.add_row({name, fixed(v.x(), 4), fixed(v.y(), 4), fixed(v.z(), 4)});
  };
  table.add_row({"", "x", "y", "z"});
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const bool absent = inputs[i].kind == core::PadInput::Kind::absent;
    if (!absent) add_row("force of " + scene.pads[i].name + ", N", solution.pad_forces[i]);
  }
  for (const core::Target& target : scene.targets) {
    add_row("displacement of " + target.name + ", mm", displacement_of(scene, solution, target.rest));
  }
  std::fputs(table.text().c_str(), stdout);
}

int run_solve(const SolveArguments& arguments) {
  const std::string extension = std::filesystem::path(arguments.out).extension().string();
  if (!arguments.out.empty() && extension != ".csv" && extension != ".vtu") {
    throw UsageError("--out: " + arguments.out + " ends neither in .csv nor in .vtu");
  }
  const std::map<std::string, double> pushes = parse_pushes(arguments.pushes);
  const core::Scene scene = load_static_scene(arguments);
  const std::vector<core::PadInput> inputs = pad_inputs(scene, pushes);

  std::vector<core::StaticIteration> iterations;
  const auto watch = [&iterations](const core::StaticIteration& iteration) { iterations.push_back(iteration); };
  const core::StaticSolution solution = core::solve_static(scene, inputs, arguments.options, watch);

  if (!arguments.out.empty()) write_solution(arguments.out, scene, solution);
  if (!arguments.curve.empty()) write_curve(arguments.curve, iterations);
  if (arguments.json) {
    std::puts(solution_json(scene, inputs, solution).dump(1).c_str());
  } else {
    print_solution(scene, inputs, solution);
  }
  if (solution.converged) return kSuccess;
  std::fprintf(stderr, "tissuectl: not converged to %g mm%s%s; what was reached is %s\n", arguments.options.tolerance,
               solution.trouble.empty() ? "" : ": ", solution.trouble.c_str(),
               arguments.out.empty() ? "printed" : ("in " + arguments.out).c_str());
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
  solve->add_option("--model", a.model, "Simulator: admm")
      ->type_name("NAME")
      ->check(CLI::IsMember({"admm"}).description(""))
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
      ->add_option("--set", a.overrides, "KEY=VALUE of bundle.json, e.g. material.poissons_ratio=0.42; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
  solve->add_option("--mesh", a.mesh, "Another mesh than the bundle's, with the same surface groups")
      ->type_name("FILE");
  solve->add_option("--tolerance", a.options.tolerance, "Residual at which it has converged, mm")
      ->type_name("MM")
      ->check(in_range(1e-14, 10.0))
      ->capture_default_str();
  solve->add_option("--max-iterations", a.options.max_iterations, "Give up after as many ADMM iterations")
      ->type_name("N")
      ->check(in_range(1, 1e7))
      ->capture_default_str();
  solve
      ->add_option("--anderson", a.options.anderson_depth,
                   "Iterations that the acceleration looks back; 0 for plain ADMM")
      ->type_name("N")
      ->check(in_range(0, 50))
      ->capture_default_str();
  solve->add_option("--load-step", a.options.load_step, "Pads move by at most this much at a time, mm")
      ->type_name("MM")
      ->check(in_range(1e-3, 1e6))
      ->capture_default_str();
  solve->add_option("--out", a.out, "Nodes: x,y,z,ux,uy,uz as .csv, or the deformed mesh as .vtu")->type_name("FILE");
  solve->add_option("--curve", a.curve, "Convergence as .csv: iteration, load, residual")->type_name("FILE");
  solve->add_flag("--json", a.json, "Print JSON, with the displacement of every marker and target");
  solve->callback([arguments, &exit_code] { exit_code = run_solve(*arguments); });
}

}  // namespace tissued::daemon
