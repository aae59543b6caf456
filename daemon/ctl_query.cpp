#include "daemon/ctl_query.hpp"

#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "daemon/alarm_report.hpp"
#include "daemon/confidence.hpp"
#include "daemon/ctl_options.hpp"
#include "daemon/prediction_client.hpp"
#include "daemon/text_table.hpp"
#include "protocol/vtk_file.hpp"

namespace tissued::daemon {
namespace {

using nlohmann::json;

struct QueryArguments {
  std::string what;
  Endpoint from = default_clients();
  KeyOption keys;
  std::string out;
  bool json = false;
};

struct Mesh {
  ReceivedMesh snapshot;
  std::vector<std::array<std::int32_t, 4>> tets;
};

double ms(std::uint64_t ns) { return static_cast<double>(ns) * 1e-6; }

std::string name_at(const std::vector<std::string>& names, std::size_t index) {
  return index < names.size() ? names[index] : "?" + std::to_string(index);
}

void print(const json& value) { std::puts(value.dump(1).c_str()); }
void print(const TextTable& table) { std::fputs(table.text().c_str(), stdout); }

std::string validity_line(protocol::Validity validity, std::uint16_t reasons) {
  std::string line = protocol::to_string(validity);
  for (const std::string& reason : reason_names(reasons)) line += ", " + reason;
  return line;
}

void query_hello(PredictionClient& client, bool as_json) {
  const protocol::HelloReply reply = client.hello();
  if (as_json) {
    print(json{{"version", reply.version.view()},
               {"model", reply.model.view()},
               {"simulator", reply.simulator.view()},
               {"units", reply.units.view()},
               {"nominal_rate_hz", reply.nominal_rate_hz},
               {"nodes", reply.node_count},
               {"tetrahedra", reply.tetrahedron_count},
               {"skin_triangles", reply.triangle_count},
               {"targets", client.names(protocol::NameKind::target)},
               {"markers", client.names(protocol::NameKind::marker)},
               {"pads", client.names(protocol::NameKind::pad)},
               {"probes", client.names(protocol::NameKind::probe)}});
    return;
  }
  TextTable table;
  const auto row = [&table](const char* key, std::string value) { table.add_row({key, std::move(value)}); };
  row("version", std::string(reply.version.view()));
  row("model", std::string(reply.model.view()));
  row("simulator", std::string(reply.simulator.view()));
  row("units", std::string(reply.units.view()));
  row("nominal rate", fixed(reply.nominal_rate_hz, 1) + " Hz");
  row("nodes", std::to_string(reply.node_count));
  row("tetrahedra", std::to_string(reply.tetrahedron_count));
  row("targets", std::to_string(reply.target_count));
  row("markers", std::to_string(reply.marker_count));
  row("pads", std::to_string(reply.pad_count));
  print(table);
}

json targets_json(const TargetAnswer& answer, const std::vector<std::string>& names,
                  const std::vector<std::string>& pad_names) {
  const protocol::Predictions& frame = answer.frame;
  json targets = json::object();
  for (const auto& target : answer.targets) {
    json& entry = targets[name_at(names, target.index)];
    entry = {{"position_mm", target.position}, {"covariance_mm2", target.covariance}};
    if (const auto radius = radius_95(target.covariance)) entry["radius_95_mm"] = *radius;
    if (target.has_truth) entry["truth_mm"] = target.truth;
    if (const auto error = error_of(target)) entry["error_mm"] = *error;
  }
  json pads = json::object();
  for (const auto& pad : answer.pads) pads[name_at(pad_names, pad.index)] = {{"force_N", pad.force}};
  return {{"validity", protocol::to_string(frame.validity)},
          {"reasons", reason_names(frame.reasons)},
          {"tracker_frame", frame.tracker_frame},
          {"stamp_ns", frame.has_stamp ? json(frame.stamp_ns) : json()},
          {"age_ms", ms(frame.age_ns)},
          {"receive_to_send_ms", ms(frame.send_ns - frame.receive_ns)},
          {"step_ms", ms(frame.step_time_ns)},
          {"iterations", frame.iterations},
          {"primal_residual_mm", frame.primal_residual},
          {"dual_residual_mm", frame.dual_residual},
          {"innovation_rms_mm", frame.innovation_rms},
          {"alarm", alarm_json(frame.alarm)},
          {"markers_used", frame.markers_used},
          {"markers_seen", frame.markers_seen},
          {"targets", targets},
          {"pads", pads}};
}

void query_targets(PredictionClient& client, bool as_json) {
  const auto names = client.names(protocol::NameKind::target);
  const auto pad_names = client.names(protocol::NameKind::pad);
  const TargetAnswer answer = client.targets();
  if (as_json) return print(targets_json(answer, names, pad_names));
  const protocol::Predictions& frame = answer.frame;
  std::printf("%s; frame %u, %.1f ms old; %u of %u markers used\n",
              validity_line(frame.validity, frame.reasons).c_str(), frame.tracker_frame, ms(frame.age_ns),
              frame.markers_used, frame.markers_seen);
  if (frame.alarm.raised) std::printf("a diagnosis is due: %s\n", alarm_text(frame.alarm).c_str());
  TextTable table;
  if (!answer.targets.empty()) table.add_row({"target", "x mm", "y mm", "z mm", "95 % mm", "error mm"});
  for (const auto& target : answer.targets) {
    const auto& p = target.position;
    table.add_row({name_at(names, target.index), fixed(p[0], 3), fixed(p[1], 3), fixed(p[2], 3),
                   fixed(radius_95(target.covariance).value_or(NAN), 3), fixed(error_of(target).value_or(NAN), 3)});
  }
  print(table);
  if (answer.pads.empty()) return;
  TextTable pads;
  pads.add_row({"pad", "Fx N", "Fy N", "Fz N"});
  for (const auto& pad : answer.pads) {
    pads.add_row(
        {name_at(pad_names, pad.index), fixed(pad.force[0], 3), fixed(pad.force[1], 3), fixed(pad.force[2], 3)});
  }
  print(pads);
}

json status_json(const DaemonStatus& status) {
  const protocol::Status& frame = status.frame;
  json counters = json::object();
  for (const auto& [name, value] : status.counters) counters[name] = value;
  return {{"validity", protocol::to_string(frame.validity)},
          {"reasons", reason_names(frame.reasons)},
          {"alarm", alarm_json(frame.alarm)},
          {"uptime_s", static_cast<double>(frame.uptime_ns) * 1e-9},
          {"subscribers", frame.subscribers},
          {"tracker_rate_hz", frame.tracker_rate_hz},
          {"step_rate_hz", frame.step_rate_hz},
          {"receive_to_send_ms",
           {{"p50", ms(frame.latency_p50_ns)}, {"p99", ms(frame.latency_p99_ns)}, {"max", ms(frame.latency_max_ns)}}},
          {"step_ms", {{"p50", ms(frame.step_p50_ns)}, {"p99", ms(frame.step_p99_ns)}, {"max", ms(frame.step_max_ns)}}},
          {"counters", counters}};
}

void query_status(PredictionClient& client, bool as_json) {
  const DaemonStatus status = client.status();
  if (as_json) return print(status_json(status));
  const protocol::Status& frame = status.frame;
  const auto percentiles = [](std::uint64_t p50, std::uint64_t p99, std::uint64_t most) -> std::string {
    if (most == 0) return "-";
    return "p50 " + fixed(ms(p50), 2) + "  p99 " + fixed(ms(p99), 2) + "  max " + fixed(ms(most), 2) + " ms";
  };
  const auto line = [](const char* key, const std::string& value) { std::printf("%-16s%s\n", key, value.c_str()); };
  line("validity", validity_line(frame.validity, frame.reasons));
  line("alarm", alarm_text(frame.alarm));
  line("uptime", fixed(static_cast<double>(frame.uptime_ns) * 1e-9, 1) + " s");
  line("subscribers", std::to_string(frame.subscribers));
  line("tracker", fixed(frame.tracker_rate_hz, 1) + " frames/s");
  line("steps", fixed(frame.step_rate_hz, 1) + " frames/s");
  line("receive to send", percentiles(frame.latency_p50_ns, frame.latency_p99_ns, frame.latency_max_ns));
  line("step", percentiles(frame.step_p50_ns, frame.step_p99_ns, frame.step_max_ns));
  TextTable table;
  for (const auto& [name, value] : status.counters) {
    if (value > 0) table.add_row({name, std::to_string(value)});
  }
  const auto zero = std::ranges::count(status.counters, 0u, &decltype(status.counters)::value_type::second);
  std::printf("counters since start; %td others are 0\n", zero);
  print(table);
}

Mesh fetch_mesh(PredictionClient& client) {
  Mesh mesh{client.mesh(protocol::Precision::float64), {}};
  for (const auto& cell : client.cells(protocol::CellKind::tetrahedron)) {
    std::array<std::int32_t, 4> tet{};
    for (std::size_t i = 0; i < 4; ++i) tet[i] = static_cast<std::int32_t>(cell[i]);
    mesh.tets.push_back(tet);
  }
  return mesh;
}

void query_mesh(PredictionClient& client, const QueryArguments& arguments) {
  const Mesh mesh = fetch_mesh(client);
  const auto& nodes = mesh.snapshot.nodes;
  if (!arguments.out.empty()) protocol::write_vtu(arguments.out, nodes, mesh.tets, {});
  if (arguments.json) {
    return print(json{{"tracker_frame", mesh.snapshot.tracker_frame}, {"nodes_mm", nodes}, {"tetrahedra", mesh.tets}});
  }
  std::printf("frame %u: %zu nodes, %zu tetrahedra\n", mesh.snapshot.tracker_frame, nodes.size(), mesh.tets.size());
  for (std::size_t axis = 0; axis < 3 && !nodes.empty(); ++axis) {
    const auto [low, high] = std::ranges::minmax(nodes, {}, [axis](const auto& node) { return node[axis]; });
    std::printf("%c  %10.3f .. %10.3f mm\n", "xyz"[axis], low[axis], high[axis]);
  }
}

json image_json(const JoinedView& view, const std::vector<std::string>& names) {
  const protocol::ProbeView& frame = view.frame;
  json image;
  if (frame.has_image) image = {{"columns", frame.size[0]}, {"rows", frame.size[1]}, {"spacing_mm", frame.spacing}};
  json targets = json::object();
  for (const auto& target : view.targets) {
    targets[name_at(names, target.index)] = {{"pixel", target.pixel},          {"inside", target.inside},
                                             {"distance_mm", target.distance}, {"distance_sd_mm", target.distance_sd},
                                             {"half_axes_px", target.axes},    {"angle_rad", target.angle}};
  }
  return {{"validity", protocol::to_string(frame.validity)},
          {"reasons", reason_names(frame.reasons)},
          {"tracker_frame", frame.tracker_frame},
          {"age_ms", ms(frame.age_ns)},
          {"seen", frame.seen},
          {"force_N", frame.force},
          {"image", image},
          {"targets", targets}};
}

void print_image(const std::string& probe, const JoinedView& view, const std::vector<std::string>& names) {
  const protocol::ProbeView& frame = view.frame;
  std::printf("%s: %s; frame %u, %.1f ms old; ", probe.c_str(), validity_line(frame.validity, frame.reasons).c_str(),
              frame.tracker_frame, ms(frame.age_ns));
  if (!frame.seen) {
    std::puts("not seen");
    return;
  }
  std::printf("pushes with (%.3f, %.3f, %.3f) N%s\n", frame.force[0], frame.force[1], frame.force[2],
              frame.has_image ? "" : "; its image is not calibrated");
  TextTable table;
  if (!view.targets.empty())
    table.add_row({"target", "u px", "v px", "inside", "from plane mm", "sd mm", "half axes px", "", "angle deg"});
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  for (const auto& target : view.targets) {
    table.add_row({name_at(names, target.index), fixed(target.pixel[0], 2), fixed(target.pixel[1], 2),
                   target.inside ? "yes" : "no", fixed(target.distance, 3), fixed(target.distance_sd, 3),
                   fixed(target.axes[0], 2), fixed(target.axes[1], 2), fixed(kDegrees * target.angle, 1)});
  }
  print(table);
}

void query_image(PredictionClient& client, bool as_json) {
  const auto names = client.names(protocol::NameKind::target);
  const auto probe_names = client.names(protocol::NameKind::probe);
  json probes = json::object();
  for (const JoinedView& view : client.probes()) {
    const std::string probe = name_at(probe_names, view.frame.index);
    if (as_json) {
      probes[probe] = image_json(view, names);
    } else {
      print_image(probe, view, names);
    }
  }
  if (as_json) print(probes);
}

int run_query(const QueryArguments& arguments) {
  if (!arguments.out.empty() && arguments.what != "mesh") throw UsageError("--out is for `query mesh`");
  PredictionClient client(arguments.from, arguments.keys.key_for(config::KeyRole::client));
  if (arguments.what == "hello") query_hello(client, arguments.json);
  if (arguments.what == "targets") query_targets(client, arguments.json);
  if (arguments.what == "status") query_status(client, arguments.json);
  if (arguments.what == "image") query_image(client, arguments.json);
  if (arguments.what == "mesh") query_mesh(client, arguments);
  return kSuccess;
}

}  // namespace

void add_query_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<QueryArguments>();
  QueryArguments& a = *arguments;
  CLI::App* query = app.add_subcommand("query", "Ask tissued once: targets, image, mesh, status or hello");
  query->footer(
      "targets  where they are, how sure that is, forces of the pads\n"
      "image    where targets are in the probes' ultrasound images, and how far from their planes; how probes push\n"
      "mesh     node positions and tetrahedra now\n"
      "status   rates, latencies, everything that was skipped or refused\n"
      "hello    version, model, simulator, sizes\n"
      "Example: tissuectl query mesh --out now.vtu");
  query->add_option("WHAT", a.what, "targets, image, mesh, status or hello")
      ->type_name("")
      ->required()
      ->check(CLI::IsMember({"targets", "image", "mesh", "status", "hello"}).description(""));
  add_endpoint(*query, "--from", a.from, "Where tissued answers its clients");
  add_keys(*query, a.keys);
  query->add_option("--out", a.out, "Write the mesh as a VTK file, .vtu")->type_name("FILE");
  query->add_flag("--json", a.json, "Print JSON in place of a table");
  query->callback([arguments, &exit_code] { exit_code = run_query(*arguments); });
}

}  // namespace tissued::daemon
