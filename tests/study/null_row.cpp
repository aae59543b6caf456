#include "tests/study/null_row.hpp"

#include <chrono>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::study {

namespace {

using Clock = std::chrono::steady_clock;

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

std::string cell(double value) {
  std::ostringstream text;
  text.precision(6);
  if (std::isfinite(value)) text << value;
  return text.str();
}

void describe(const NullSession& null, NullRow& row) {
  const core::RecordedSession& session = null.session;
  const core::Scene& scene = session.scene;
  auto& cells = row.cells;
  cells["seed"] = std::to_string(null.seed);
  cells["body"] = null.shape;
  cells["redraws"] = std::to_string(null.redraws);
  cells["length_mm"] = cell((scene.mesh.rest.colwise().maxCoeff() - scene.mesh.rest.colwise().minCoeff()).maxCoeff());
  cells["tets"] = std::to_string(scene.mesh.tet_count());
  cells["nodes"] = std::to_string(scene.mesh.node_count());
  cells["pads"] = std::to_string(scene.pads.size());
  cells["markers"] = std::to_string(scene.markers.size());
  cells["targets"] = std::to_string(scene.targets.size());
  cells["trials"] = std::to_string(session.trials.size());
  cells["frames"] = std::to_string(null.frames);
  cells["rate_hz"] = cell(scene.rate);
  cells["targets_seen"] = null.has_targets ? "1" : "0";
  cells["force_seen"] = null.has_force ? "1" : "0";
  cells["marker_noise_mm"] = cell(session.marker_noise);
  cells["force_noise_N"] = cell(session.force_noise);
  cells["marker_offset_mm"] = cell(null.marker_offset);
  cells["missing"] = cell(null.missing);
  cells["modulus_assumed_kPa"] = cell(scene.material.youngs_modulus);
  cells["modulus_true_kPa"] = cell(null.youngs_modulus);
  cells["ratio_assumed"] = cell(scene.material.poissons_ratio);
  cells["ratio_true"] = cell(null.poissons_ratio);
}

void report(const core::Diagnosis& diagnosis, NullRow& row) {
  auto& cells = row.cells;
  cells["verdict"] = core::name_of(diagnosis.verdict);
  for (const core::Finding& finding : diagnosis.findings)
    cells["findings"] += (cells["findings"].empty() ? "" : " ") + finding.kind;
  cells["likeliest"] = diagnosis.grounds.likeliest;
  cells["advantage"] = cell(diagnosis.grounds.advantage);
  cells["likeliest_pair"] = diagnosis.grounds.likeliest_pair;
  if (!diagnosis.grounds.likeliest_pair.empty()) cells["pair_gain"] = cell(diagnosis.grounds.pair_gain);
  cells["structure"] = cell(diagnosis.grounds.structure);
  cells["discretisation_mm"] = cell(diagnosis.discretisation_marker_mm);
  cells["assumed_mm"] = cell(diagnosis.trials.assumed.marker_mm);
  cells["explained_mm"] = cell(diagnosis.trials.explained.marker_mm);
  cells["held_out_mm"] = cell(diagnosis.held_out.explained.marker_mm);
  const core::Fit& fit = diagnosis.explained.best();
  if (!fit.solved || !fit.has("youngs_modulus")) return;
  cells["modulus_fitted_kPa"] = cell(fit.value("youngs_modulus"));
  cells["modulus_sd_kPa"] = cell(fit.sd("youngs_modulus"));
  cells["ratio_fitted"] = cell(fit.value("poissons_ratio"));
  cells["ratio_sd"] = cell(fit.sd("poissons_ratio"));
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> parts(1);
  for (char c : line) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

}  // namespace

const std::vector<std::string>& columns() {
  static const std::vector<std::string> kColumns{
      "seed", "body", "redraws", "length_mm", "tets", "nodes", "pads", "markers", "targets", "trials", "frames",
      "rate_hz", "targets_seen", "force_seen", "marker_noise_mm", "force_noise_N", "marker_offset_mm", "missing",
      "modulus_assumed_kPa", "modulus_true_kPa", "ratio_assumed", "ratio_true",
      // what was said
      "verdict", "findings", "likeliest", "advantage", "likeliest_pair", "pair_gain", "structure", "discretisation_mm",
      "assumed_mm", "explained_mm", "held_out_mm", "modulus_fitted_kPa", "modulus_sd_kPa", "ratio_fitted", "ratio_sd",
      "truth_seconds", "diagnosis_seconds"};
  return kColumns;
}

double NullRow::number(const std::string& column) const {
  const std::string& value = text(column);
  return value.empty() ? std::numeric_limits<double>::quiet_NaN() : std::stod(value);
}

NullRow study_null(std::uint64_t seed) {
  NullRow row;
  row.seed = seed;
  for (const std::string& column : columns()) row.cells[column];
  const Clock::time_point begin = Clock::now();
  const NullSession null = draw_null(seed);
  describe(null, row);
  row.cells["truth_seconds"] = cell(since(begin));
  core::SearchOptions options;
  options.threads = 1;
  options.budget = 1e9;
  const Clock::time_point drawn = Clock::now();
  try {
    report(core::diagnose(null.session, options), row);
  } catch (const core::ModelError&) {
    row.cells["verdict"] = "failed";
  }
  row.cells["diagnosis_seconds"] = cell(since(drawn));
  return row;
}

void write_header(std::ostream& out) {
  for (std::size_t i = 0; i < columns().size(); ++i) out << (i > 0 ? "," : "") << columns()[i];
  out << '\n';
}

void write_row(const NullRow& row, std::ostream& out) {
  for (std::size_t i = 0; i < columns().size(); ++i) out << (i > 0 ? "," : "") << row.text(columns()[i]);
  out << std::endl;  // one null at a time: an interrupted study goes on from here
}

std::vector<NullRow> read_rows(const std::string& file) {
  std::vector<NullRow> rows;
  std::ifstream in(file);
  std::string line;
  if (!std::getline(in, line)) return rows;
  if (split(line) != columns()) throw std::runtime_error(file + ": has other columns; move it away or name another");
  while (std::getline(in, line)) {
    const std::vector<std::string> parts = split(line);
    if (parts.size() != columns().size() || in.eof()) continue;
    NullRow row;
    for (std::size_t i = 0; i < parts.size(); ++i) row.cells[columns()[i]] = parts[i];
    row.seed = std::stoull(parts.front());
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace tissued::study
