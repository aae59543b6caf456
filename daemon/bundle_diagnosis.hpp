#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "core/diagnosis/diagnosis.hpp"

namespace tissued::daemon {

struct BundleDiagnosisOptions {
  int threads = 0;                               // 0: as many as there are processors
  double budget = core::SearchOptions().budget;  // s
  bool processor_time = false;                   // the budget's, per thread; else by the clock
  bool quick = false;                            // do not judge the elements by finer ones
};

/// Diagnoses the bundle in `folder`; writes report.json, report.html and model.json into `out`, each whole or not at
/// all. Throws where the bundle cannot be read or simulated, or nothing can be written.
core::Diagnosis diagnose_bundle(const std::string& folder, const std::filesystem::path& out,
                                const BundleDiagnosisOptions& options, const std::atomic<bool>& interrupted,
                                const std::function<void(double, const std::string&)>& progress);

/// What a table tells of one bundle of several: {bundle, verdict, findings, assumed_mm, explained_mm, held_out_mm,
/// noise_mm, seconds, complete}; misfits are null where nothing was seen.
nlohmann::json summary_of(const core::Diagnosis& diagnosis);

/// A diagnosis in a few lines for a terminal.
std::string terminal_text(const core::Diagnosis& diagnosis);

/// The summaries of several bundles as a table: {folder, error} instead where one failed.
std::string summary_table(const nlohmann::json& summaries);

}  // namespace tissued::daemon
